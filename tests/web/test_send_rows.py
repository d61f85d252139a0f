"""What a row of the transmit list can send: ramps and counters, sequences, exact cycles, LIN, signals changed live."""

from __future__ import annotations

import itertools
import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import canwire
from canwire import BadValue, Frame, LinFrame, LinMode, LinMonitorMode
from canwire.web.database import Database
from canwire.web.send import changing, steps
from canwire.web.send.row import Content, Row
from tests.cases import each
from tests.hubs import LONG_S
from tests.web.conftest import holds, served_site, somebody
from tests.web.test_send import GOOD, Bench, receiving

if TYPE_CHECKING:
    from collections.abc import Callable

    import httpx2 as httpx
    from playwright.sync_api import Page

pytest.importorskip("cantools")
pytestmark = pytest.mark.conforms("PG-03")

DBC = """VERSION ""
BU_: ECU
BO_ 256 Engine: 8 ECU
 SG_ Speed : 0|16@1+ (0.25,0) [0|16000] "rpm" ECU
"""


def until(client: httpx.Client, enough: Callable[[str], bool]) -> str:
    """The list, once it says so."""
    while not enough(listed := client.get("/send/list").text.replace("\n", "")):
        pass
    return listed


@each(
    ("text", "values"),
    [
        ("byte 0 0..3", [0, 1, 2, 3, 0]),
        ("byte 0 : 10..20/5", [10, 15, 20, 10]),
        ("byte 0 0..2..0", [0, 1, 2, 1, 0, 1]),
        ("byte 0 7..7..7", [7, 7]),
        ("Speed = -1..1/0.5", [-1, -0.5, 0, 0.5, 1, -1]),
    ],
)
def test_a_change_counts_or_climbs(text: str, values: list[float]) -> None:
    (change,) = changing.parsed(text)
    assert [change.value(number) for number in range(len(values))] == values
    assert changing.parsed(str(change)) == (change,)


@each(
    "text",
    ["byte 0", "byte 0 3..1", "byte 0 0..256", "byte 0 0..1/0", "Speed 0..5..1", "0..5", "Speed 0..9e9"],
)
def test_what_is_no_change_is_named(text: str) -> None:
    with pytest.raises(BadValue):
        changing.parsed(text)


def test_a_row_s_bytes_change_with_each_frame() -> None:
    bench = Bench()
    content = Content(Frame(0x100, b"\x00\xff"), changes=changing.parsed("byte 0 5..6"))
    bench.list.start(bench.list.put(Row(0, "HW1:0", content, cycle_ms=10)).number)
    sent = [content.at(number).data[0] for number in range(3)]
    bench.run_until(0.02)
    assert sent == [5, 6, 5]
    assert bench.list.rows[0].queued == 3


def test_a_sequence_keeps_its_order_and_its_pauses_and_waits_for_a_frame_that_cannot_go() -> None:
    bench = Bench()
    found = steps.parsed("100#; 10 ms; 200#11\n20;300#", Database(), lin=False)
    row = bench.list.put(Row(0, "HW1:0", Content(Frame(0x100), steps=found), cycle_ms=100, most=2))
    bench.list.start(row.number)
    bench.run_until(0.05)
    assert [(round(time_s * 1000), id) for time_s, _, id in bench.sent] == [
        (0, 0x100),
        (10, 0x200),
        (30, 0x300),
    ]
    bench.full = True
    bench.run_until(0.12)
    assert bench.list.rows[0].trouble
    bench.full = False
    bench.run_until(1.0)
    assert [id for _, _, id in bench.sent] == [0x100, 0x200, 0x300] * 2
    assert not bench.list.rows[0].running


def test_send_plays_a_sequence_once() -> None:
    bench = Bench()
    steps_ = (steps.Step(Frame(1), 5.0), steps.Step(Frame(2), 0.0))
    row = bench.list.put(Row(0, "HW1:0", Content(Frame(1), steps=steps_)))
    bench.list.send_now(row.number)
    bench.run_until(1.0)
    assert [id for _, _, id in bench.sent] == [1, 2]
    assert not bench.list.rows[0].running


@each(
    ("fields", "fault"),
    [
        ({"changes": "byte 2 0..3"}, "changes"),
        ({"changes": "Speed 0..3"}, "changes"),
        ({"changes": "soon"}, "changes"),
        ({"exact": "on"}, "cycle"),
        ({"exact": "on", "cycle": "10", "changes": "byte 0 0..3"}, "exact"),
        ({"format": "sequence", "steps": ""}, "steps"),
        ({"format": "sequence", "steps": "123#1"}, "steps"),
        ({"format": "sequence", "steps": "Engine Speed=1"}, "steps"),
        ({"format": "lin"}, "id"),
        ({"format": "header", "id": "11", "dlc": "9"}, "dlc"),
    ],
)
def test_faults_are_at_their_fields(asker: httpx.Client, fields: dict[str, str], fault: str) -> None:
    answer = asker.post("/send/put", data={**GOOD, **fields})
    assert answer.status_code == 422
    assert set(answer.json()["faults"]) == {fault}


@pytest.mark.finding("page B4")
def test_the_hub_keeps_exact_cycles_and_counts_what_was_on_the_bus(
    client: httpx.Client, hub: canwire.Hub
) -> None:
    with receiving(hub) as channel:
        client.post("/send/put", data={**GOOD, "cycle": "10", "exact": "on", "changes": "byte 1 0..255"})
        assert client.post("/send/start", data={"number": "1"}).status_code == 200
        assert canwire.find_lines(hub, "can0")[0].status(hub).scheduler_holder
        frames = [channel.receive(LONG_S) for _ in range(5)]
        assert client.post("/send/stop", data={"number": "1"}).status_code == 200
        stamps = [frame.timestamp_ns for frame in frames if frame is not None]
        apart = {later - earlier for earlier, later in itertools.pairwise(stamps)}
        assert max(apart) - min(apart) < 100_000  # the hub's ticks, whatever this process was busy with
        assert [frame.data[1] for frame in frames if frame is not None] == [0x22, 0x23, 0x24, 0x25, 0x26]
        came = len(frames) + len(channel.receive_many(10_000))
        sent = tuple(
            f'data-label="Sent">{number}<' for number in (came - 1, came)
        )  # one was on its way perhaps
        until(client, lambda listed: any(one in listed for one in sent))
        assert not canwire.find_lines(hub, "can0")[0].status(hub).scheduler_holder


def test_an_exact_row_is_changed_while_it_cycles_and_ends_after_its_count(
    client: httpx.Client, hub: canwire.Hub
) -> None:
    with receiving(hub) as channel:
        client.post("/send/put", data={**GOOD, "cycle": "5", "exact": "on", "most": "3"})
        client.post("/send/put", data={**GOOD, "id": "124", "cycle": "5", "exact": "on"})
        client.post("/send/start", data={"number": "1"})
        until(client, lambda listed: 'data-post="/send/stop"' not in listed)
        assert [channel.receive(LONG_S) for _ in range(3)] == [Frame(0x123, b"\x11\x22")] * 3
        client.post("/send/start", data={"number": "2"})
        assert channel.receive(LONG_S) == Frame(0x124, b"\x11\x22")
        assert client.post("/send/change", data={"number": "2", "data": "33"}).status_code == 200
        while channel.receive(LONG_S) != Frame(0x124, b"\x33"):
            pass
        client.post("/send/stop-all")


def test_a_cycle_that_the_list_cannot_keep_is_told(client: httpx.Client, hub: canwire.Hub) -> None:
    with receiving(hub):
        client.post("/send/put", data={**GOOD, "cycle": "1.55501", "exact": "on"})
        answer = client.post("/send/start", data={"number": "1"})
        assert answer.status_code == 409
        assert "steps of 0.1 ms" in answer.json()["message"]


@pytest.mark.finding("page 10")
def test_signals_are_changed_by_name_while_the_row_cycles(
    hub_address: str, hub: canwire.Hub, tmp_path: Path
) -> None:
    path = tmp_path / "car.dbc"
    path.write_text(DBC)
    with receiving(hub) as channel, served_site(hub_address, [str(path)]) as site, somebody(site) as client:
        row = {"line": GOOD["line"], "message": "Engine", "signal.Speed": "1000", "cycle": "5"}
        assert client.post("/send/put", data=row).status_code == 200
        client.post("/send/start", data={"number": "1"})
        assert channel.receive(LONG_S) == Frame(0x100, (4000).to_bytes(8, "little"))
        listed = client.get("/send/list").text
        assert 'name="signal.Speed" value="1000"' in listed
        assert "rpm" in listed
        assert client.post("/send/change", data={"number": "1", "signal.Speed": "9e9"}).status_code == 422
        assert client.post("/send/change", data={"number": "1", "signal.Speed": "500"}).status_code == 200
        while channel.receive(LONG_S) != Frame(0x100, (2000).to_bytes(8, "little")):
            pass
        client.post("/send/change", data={"number": "1", "changes": "Speed 0..16000/4000"})
        missing = {0, 4000, 8000, 12000, 16000}
        while missing:  # after frames that were on their way before the change
            frame = channel.receive(LONG_S)
            assert frame, missing
            missing.discard(int.from_bytes(frame.data, "little") // 4)


@pytest.fixture
def listening(hub: canwire.Hub) -> canwire.Monitor:
    """What happens on lin0."""
    place = canwire.find_lines(hub, "lin0")[0]
    monitor = hub.open_monitor(place.board.id, place.line)
    monitor.set_up(LinMonitorMode(receive=256))
    monitor.activate()
    return monitor


def heard(monitor: canwire.Monitor, count: int) -> list[LinFrame]:
    """The next frames, without what else happens."""
    found: list[LinFrame] = []
    while len(found) < count:
        message = monitor.receive(LONG_S)
        assert message is not None
        if isinstance(message, LinFrame):
            found.append(message)
    return found


@pytest.mark.finding("page B4")
def test_a_lin_line_is_started_and_sends_frames_headers_and_a_schedule(
    client: httpx.Client, hub: canwire.Hub, listening: canwire.Monitor
) -> None:
    line = canwire.find_lines(hub, "lin0")[0].address
    row = {**GOOD, "line": line, "format": "lin", "id": "10"}
    client.post("/send/put", data=row)
    assert "no running master" in client.post("/send/now", data={"number": "1"}).json()["message"]
    up = client.post("/send/lin-up", data={"line": line, "rate": "19200", "role": "master"})
    assert up.status_code == 200, up.text
    assert client.post("/send/now", data={"number": "1"}).status_code == 200
    assert heard(listening, 1) == [LinFrame(0x10, b"\x11\x22")]
    until(client, lambda listed: 'data-label="Sent">1' in listed)
    client.post("/send/stop", data={"number": "1"})
    answer = client.post(
        "/send/schedule", data={"line": line, "slots": "12#0102@10ms 13#0304@10ms", "rounds": "2"}
    )
    assert answer.status_code == 200, answer.text
    assert heard(listening, 4) == [LinFrame(0x12, b"\x01\x02"), LinFrame(0x13, b"\x03\x04")] * 2
    assert "runs a schedule" in client.get("/send/list").text
    assert client.post("/send/schedule-stop", data={"line": line}).status_code == 200
    assert "runs a schedule" not in client.get("/send/list").text
    assert client.post("/send/lin-down", data={"line": line}).status_code == 200


def test_the_control_of_a_lin_line_is_given_back(client: httpx.Client, hub: canwire.Hub) -> None:
    place = canwire.find_lines(hub, "lin0")[0]
    client.post("/send/lin-up", data={"line": place.address, "rate": "19200", "role": "master"})
    client.post("/send/put", data={**GOOD, "line": place.address, "format": "lin", "id": "10"})
    client.post("/send/now", data={"number": "1"})
    client.post("/send/remove", data={"number": "1"})
    hub.open_lin_control(place.board.id, place.line).close()
    assert hub.lin_status(place.board.id, place.line).status.running  # nobody else has to hold it
    again = client.post("/send/lin-up", data={"line": place.address, "rate": "10000", "role": "slave"})
    assert again.status_code == 200, again.text
    client.post("/send/lin-down", data={"line": place.address})
    with hub.open_lin_control(place.board.id, place.line) as control:
        control.initialise(LinMode(True, 9600))


@each(
    ("path", "fields", "faults"),
    [
        ("lin-up", {"line": "HW1:7", "rate": "5", "role": "king"}, {"rate", "role"}),
        ("schedule", {"line": "HW1:7", "slots": "what"}, {"slots"}),
        ("schedule", {"line": "HW1:7", "table": "db-9/x"}, {"table"}),
        ("schedule", {"line": "HW1:7", "slots": ""}, {"slots"}),
    ],
)
def test_wrong_wishes_for_lin_are_told(
    asker: httpx.Client, path: str, fields: dict[str, str], faults: set[str]
) -> None:
    answer = asker.post(f"/send/{path}", data=fields)
    assert answer.status_code == 422
    assert set(answer.json()["faults"]) == faults


def test_a_list_with_every_kind_of_row_is_saved_and_loaded(client: httpx.Client) -> None:
    for extra in (
        {"changes": "byte 0 0..255", "exact": "on", "cycle": "10"},
        {"format": "sequence", "steps": "123#; 10\n456#11", "cycle": "100"},
        {"format": "lin", "id": "10", "checksum": "on"},
        {"format": "header", "id": "11", "dlc": "4"},
    ):
        assert client.post("/send/put", data={**GOOD, **extra}).status_code == 200
    saved = client.get("/send/file").text
    for number in range(1, 5):
        client.post("/send/remove", data={"number": str(number)})
    assert client.post("/send/load", data={"list": saved}).json()["message"] == "4 rows were added."
    assert client.get("/send/file").text == saved


@pytest.fixture
def view() -> str:
    return "send"


@pytest.mark.finding("page 10")
def test_a_browser_offers_its_last_list_where_the_server_has_none(page: Page, client: httpx.Client) -> None:
    page.get_by_role("button", name="New").click()
    page.get_by_label("Identifier, hex").fill("321")
    with page.expect_response("**/send/file"):  # what the browser keeps
        page.get_by_role("button", name="Keep").click()
    while "321" not in str(page.evaluate("localStorage.getItem('canwire.send.kept')")):
        pass
    (number,) = re.findall(r'data-row="(\d+)"', client.get("/send/list").text)
    client.post("/send/remove", data={"number": number})  # as a server that begins anew
    page.reload()
    page.get_by_role("button", name="Load the last list (1 rows)").click()
    page.get_by_text("1 rows were added.").wait_for()
    assert ">321" in client.get("/send/list").text


def test_a_field_that_is_typed_into_is_not_taken_away_and_counts_go_on(
    page: Page, hub: canwire.Hub, client: httpx.Client
) -> None:
    with receiving(hub):
        client.post("/send/put", data={**GOOD, "cycle": "10"})
        field = page.locator("#data-1")
        field.fill("AB")
        client.post("/send/start", data={"number": "1"})
        page.locator(".counted", has_text=re.compile("[1-9]")).wait_for()
        assert field.input_value() == "AB"
        field.press("Escape")
        holds(field, "11 22")
        client.post("/send/stop", data={"number": "1"})
