"""An opened log played onto a line, and marked rows saved."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import canwire
from canwire import Frame, LinFrame, LinMonitorMode, LogEntry
from tests.hubs import LONG_S
from tests.web.conftest import at, tab
from tests.web.test_send import receiving
from tests.web.test_send_rows import heard
from tests.web.trace.watching import rows_with

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Browser

    from canwire.web.server import Site

pytestmark = pytest.mark.conforms("N-53")

START_NS = 1_700_000_000_000_000_000
STEP_NS = 10_000_000


def entry(number: int, channel: str = "can0") -> LogEntry:
    stamp_ns = START_NS + number * STEP_NS
    return LogEntry(stamp_ns, channel, Frame(0x100 + number, bytes([number]), timestamp_ns=stamp_ns), "R")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "drive.blf"
    lin_ns = START_NS + 5 * STEP_NS
    with canwire.create_log(path) as writer:
        writer.write_many([entry(number) for number in range(6)])
        writer.write_many([LogEntry(lin_ns, "lin0", LinFrame(0x10, b"\x01", timestamp_ns=lin_ns), "R")])
        writer.write_many([entry(number) for number in range(6, 12)])
    return path


def opened(client: httpx.Client, path: Path) -> str:
    key = str(client.post("/trace/open", params={"name": path.name}, content=path.read_bytes()).json()["key"])
    while client.get("/trace/lines", params={"source": key}).json()["logs"][-1]["reading"]:
        pass
    return key


def until_over(client: httpx.Client) -> dict[str, Any]:
    while (played := client.get("/trace/lines").json()["replay"])["running"]:
        pass
    return dict(played)


def channels(client: httpx.Client, key: str) -> dict[str, str]:
    lines = client.get("/trace/lines", params={"source": key}).json()["lines"]
    return {line["address"]: line["kind"] for line in lines}


def test_a_log_s_channels_are_what_was_on_them(client: httpx.Client, log: Path) -> None:
    kinds = channels(client, opened(client, log))
    assert sorted(kinds.values()) == ["CAN", "LIN"]


def test_frames_are_played_in_their_order_at_their_times(
    client: httpx.Client, hub: canwire.Hub, log: Path
) -> None:
    key = opened(client, log)
    can = next(name for name, kind in channels(client, key).items() if kind == "CAN")
    with receiving(hub) as channel:
        line = canwire.find_lines(hub, "can0")[0].address
        wish = {"source": key, f"line.{can}": line, "speed": "2"}
        begun_s = time.monotonic()
        assert client.post("/trace/replay", data=wish).status_code == 200
        came = [channel.receive(LONG_S) for _ in range(12)]
        assert [frame.id for frame in came if frame is not None] == [0x100 + number for number in range(12)]
        assert time.monotonic() - begun_s >= 11 * STEP_NS / 2 / 1e9  # however late it is, nothing comes early
        played = until_over(client)
        assert (played["sent"], played["delivered"], played["skipped"], played["trouble"]) == (12, 12, 0, "")
        part = {**wish, "speed": "0", "from": "0.02", "to": "0.08", "filter": "!104"}
        assert client.post("/trace/replay", data=part).status_code == 200
        came = [channel.receive(LONG_S) for _ in range(5)]
        assert [frame.id - 0x100 for frame in came if frame is not None] == [2, 3, 5, 6, 7]
        assert until_over(client)["delivered"] == 5


@pytest.mark.finding("page B5")
def test_every_channel_is_played_onto_a_line_of_its_kind(
    client: httpx.Client, hub: canwire.Hub, tmp_path: Path
) -> None:
    """LIN frames with their responses, headers alone; neither bus waits for the other's."""
    sent = [LinFrame(0x10, b"\x01\x02"), LinFrame(0x11, header_only=True), LinFrame(0x12, b"\x03")]
    path = tmp_path / "both.blf"
    with canwire.create_log(path) as writer:
        writer.write_many([entry(number) for number in range(3)])
        writer.write_many([LogEntry(START_NS + 1 + k, "lin0", one, "R") for k, one in enumerate(sent)])
    key = opened(client, path)
    named = {kind: name for name, kind in channels(client, key).items()}
    place = canwire.find_lines(hub, "lin0")[0]
    up = {"line": place.address, "rate": "19200", "role": "master"}
    assert client.post("/send/lin-up", data=up).status_code == 200
    with receiving(hub) as channel, hub.open_monitor(place.board.id, place.line) as monitor:
        monitor.set_up(LinMonitorMode(receive=64))
        monitor.activate()
        wish = {"source": key, "speed": "1", f"line.{named['LIN']}": place.address}
        wish[f"line.{named['CAN']}"] = canwire.find_lines(hub, "can0")[0].address
        answer = client.post("/trace/replay", data=wish)
        assert answer.status_code == 200, answer.text
        assert [channel.receive(LONG_S) for _ in range(3)] == [Frame(0x100 + k, bytes([k])) for k in range(3)]
        assert heard(monitor, 2) == [sent[0], sent[2]]
        played = until_over(client)
        assert (played["sent"], played["delivered"], played["skipped"], played["trouble"]) == (6, 5, 0, "")
    hub.open_lin_control(place.board.id, place.line).close()  # it was given back


def test_it_is_stopped_and_one_at_a_time(client: httpx.Client, hub: canwire.Hub, log: Path) -> None:
    key = opened(client, log)
    wish = {"source": key, "speed": "0.001"}
    with receiving(hub) as channel:
        can = next(iter(channels(client, key)))
        wish[f"line.{can}"] = canwire.find_lines(hub, "can0")[0].address
        assert client.post("/trace/replay", data=wish).status_code == 200
        assert channel.receive(LONG_S) is not None
        answer = client.post("/trace/replay", data=wish)
        assert answer.status_code == 409
        assert "stop it first" in answer.json()["message"]
        assert client.post("/trace/replay-stop").status_code == 200
        assert until_over(client)["sent"] == 1


@pytest.mark.parametrize(
    ("fields", "status"),
    [
        ({"line.can0": ""}, 422),
        ({"line.other": "HW000001:0"}, 422),  # two channels onto one line
        ({"speed": "fast"}, 422),
        ({"from": "x"}, 422),
        ({"filter": "what is this"}, 422),
        ({"source": "log-99"}, 409),
        ({"line.can0": "HW9:9"}, 409),
        ({}, 409),  # the line does not run
        ({"line.can0": "HW000001:2"}, 409),  # nor does this LIN line
    ],
)
def test_what_cannot_be_played_is_told(
    client: httpx.Client, log: Path, fields: dict[str, str], status: int
) -> None:
    key = opened(client, log)
    wish = {"source": key, "line.can0": "HW000001:0", "speed": "1"}
    assert client.post("/trace/replay", data={**wish, **fields}).status_code == status


def test_marked_rows_are_saved_alone(client: httpx.Client, log: Path, tmp_path: Path) -> None:
    key = opened(client, log)
    names = ",".join(channels(client, key))
    query = {"source": key, "lines": names, "format": "asc", "errors": "true", "numbers": "7,1,3"}
    answer = client.get("/trace/log", params=query)
    assert answer.status_code == 200, answer.text
    path = tmp_path / "marked.asc"
    path.write_bytes(answer.content)
    with canwire.open_log(path) as saved:
        assert [one.frame.id for one in saved if isinstance(one.frame, Frame)] == [0x101, 0x103, 0x106]
    assert client.get("/trace/log", params={**query, "numbers": "one"}).status_code == 422


def test_in_the_browser_a_log_is_replayed_and_marks_are_saved(
    browser: Browser, site: Site, hub: canwire.Hub, log: Path
) -> None:
    with receiving(hub) as channel, tab(browser, at(site, "trace")) as page:
        page.locator("#log-file").set_input_files(log)
        rows_with(page, id="10B").wait_for()
        page.locator(".trace-head .c-pid").wait_for()  # there is LIN in this log
        page.get_by_role("button", name="Replay").click()
        page.get_by_label("Speed").fill("0")
        page.get_by_role("button", name="Start the replay").click()
        assert [channel.receive(LONG_S) for _ in range(3)] == [Frame(0x100 + k, bytes([k])) for k in range(3)]
        page.get_by_text("12 frames sent, 12 acknowledged or heard").wait_for()
        rows_with(page, id="103").click()
        page.keyboard.press("m")
        page.locator("#save").click()
        page.locator("#saving-form [name=what]").select_option("marked")
        page.get_by_label("Format of the file").select_option("candump")
        with page.expect_download() as downloading:
            page.locator("#save-now").click()
        (line,) = downloading.value.path().read_text().splitlines()
        assert "103#03" in line


def test_the_dialog_waits_for_the_channels_of_a_log_that_has_just_been_opened(
    browser: Browser, steady: Site, log: Path
) -> None:
    its_lines = "**/trace/lines?source=log*"
    with tab(browser, at(steady, "trace")) as page:
        page.route(its_lines, lambda route: None)
        with page.expect_request(its_lines):
            page.locator("#log-file").set_input_files(log)
        with page.expect_response("**/send/choices"):
            page.get_by_role("button", name="Replay").click()
        page.unroute_all()  # requests that wait go their way now
        page.get_by_label("can0 (CAN)").wait_for()
        page.get_by_label("lin0 (LIN)").wait_for()
        page.keyboard.press("Escape")
        page.get_by_role("button", name="Close this log").click()
        page.get_by_text("drive.blf is closed.").wait_for()
