"""The transmit list, in time handed in; its view; and frames from the browser to the bus."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest

import canwire
from canwire import BadValue, ChannelMode, Frame, InUse, QueueFull, WantedMode
from canwire.web.send.row import Content, Row, Sent
from canwire.web.send.transmit_list import MOST_ROWS, TransmitList
from tests.cases import each
from tests.hubs import LONG_S

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Page, Route

pytestmark = pytest.mark.conforms("PG-03")


class NoLists:
    """A hub without cyclic lists."""

    def start(self, row: Row) -> None:
        raise InUse(f"row {row.number}: somebody else has the list")

    def stop(self, number: int) -> None:
        pass

    def over(self, number: int) -> str | None:
        return None


class Bench:
    """A list whose clock stands until it is moved; its own thread is ended, so that `fire` is the test's."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.sent: list[tuple[float, str, int]] = []
        self.full = False
        self.dropped: list[int] = []
        self.list = TransmitList(self._send, self.dropped.append, NoLists(), lambda: self.now_s)
        self.list.close()

    def _send(self, _: int, line: str, frame: Sent) -> None:
        if self.full:
            raise QueueFull("channel", 256)
        self.sent.append((self.now_s, line, frame.id))

    def run_until(self, end_s: float) -> None:
        while (pause_s := self.list.fire()) is not None and self.now_s + pause_s <= end_s:
            self.now_s += pause_s


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_cycle_begins_immediately_and_keeps_its_pace(bench: Bench) -> None:
    row = bench.list.put(Row(0, "HW1:0", Content(Frame(0x100)), cycle_ms=10))
    bench.list.start(row.number)
    bench.run_until(0.035)
    assert [round(time_s * 1000) for time_s, _, _ in bench.sent] == [0, 10, 20, 30]
    assert bench.list.rows[0].queued == 4


def test_a_count_ends_the_cycle(bench: Bench) -> None:
    row = bench.list.put(Row(0, "HW1:0", Content(Frame(0x100)), cycle_ms=10, most=3))
    bench.list.start(row.number)
    bench.run_until(1.0)
    assert len(bench.sent) == 3
    assert not bench.list.rows[0].running


def test_who_is_late_sends_no_burst(bench: Bench) -> None:
    row = bench.list.put(Row(0, "HW1:0", Content(Frame(0x100)), cycle_ms=10))
    bench.list.start(row.number)
    bench.list.fire()
    bench.now_s = 5.0
    bench.list.fire()
    bench.list.fire()
    assert len(bench.sent) <= 3


def test_two_rows_have_cycles_of_their_own(bench: Bench) -> None:
    for identifier, cycle_ms in ((1, 10), (2, 25)):
        bench.list.start(
            bench.list.put(Row(0, "HW1:0", Content(Frame(identifier)), cycle_ms=cycle_ms)).number
        )
    bench.run_until(0.1)
    assert [identifier for _, _, identifier in bench.sent].count(1) == 11
    assert [identifier for _, _, identifier in bench.sent].count(2) == 5


def test_what_cannot_be_queued_is_counted_and_told(bench: Bench) -> None:
    row = bench.list.put(Row(0, "HW1:0", Content(Frame(0x100)), cycle_ms=10))
    bench.full = True
    with pytest.raises(QueueFull):
        bench.list.send_now(row.number)
    bench.list.start(row.number)
    bench.list.fire()
    (now,) = bench.list.rows
    assert (now.queued, now.failed) == (0, 2)
    assert "full" in now.trouble


@pytest.mark.finding("page 10")
def test_changing_a_row_keeps_its_cycle_and_its_count(bench: Bench) -> None:
    row = bench.list.put(Row(0, "HW1:0", Content(Frame(0x100)), cycle_ms=10))
    bench.list.start(row.number)
    bench.list.fire()
    bench.list.put(Row(row.number, "HW1:1", Content(Frame(0x200)), cycle_ms=20))
    (now,) = bench.list.rows
    assert (now.running, now.queued, now.line, now.frame.id) == (True, 1, "HW1:1", 0x200)


def test_a_row_that_is_stopped_or_removed_takes_back_what_waits(bench: Bench) -> None:
    for _ in range(2):
        bench.list.start(bench.list.put(Row(0, "HW1:0", Content(Frame(0x100)), cycle_ms=10)).number)
    bench.list.stop(1)
    bench.list.remove(2)
    assert bench.dropped == [1, 2]


@pytest.mark.parametrize(
    "do", [TransmitList.remove, TransmitList.send_now, TransmitList.start, TransmitList.stop]
)
def test_a_row_that_has_gone_is_named(bench: Bench, do: Callable[[TransmitList, int], None]) -> None:
    with pytest.raises(BadValue, match="row 7"):
        do(bench.list, 7)


def test_the_list_has_an_end(bench: Bench) -> None:
    for _ in range(MOST_ROWS):
        bench.list.put(Row(0, "HW1:0", Content(Frame(1))))
    with pytest.raises(BadValue, match=str(MOST_ROWS)):
        bench.list.put(Row(0, "HW1:0", Content(Frame(1))))


GOOD = {"line": "HW000001:0", "format": "classic", "id": "123", "data": "11 22", "cycle": "", "key": ""}


@each(
    ("field", "value"),
    [
        ("id", "800"),
        ("id", "xyz"),
        ("id", ""),
        ("id", "-1"),
        ("data", "1"),
        ("data", "zz"),
        ("data", "00" * 9),
        ("cycle", "-1"),
        ("cycle", "0.5"),
        ("cycle", "soon"),
        ("key", "%"),
        ("key", "ab"),
        ("most", "-1"),
        ("format", "vax"),
        ("line", ""),
    ],
)
def test_wrong_values_are_told_at_their_fields_and_no_row_is_made(
    asker: httpx.Client, field: str, value: str
) -> None:
    answer = asker.post("/send/put", data={**GOOD, field: value})
    assert answer.status_code == 422
    assert set(answer.json()["faults"]) == {field}
    assert "data-row" not in asker.get("/send/list").text


@contextmanager
def receiving(hub: canwire.Hub) -> Iterator[canwire.HubChannel]:
    """Two lines of can0 run; this channel hears the second."""
    first, second = canwire.find_lines(hub, "can0")[:2]
    with (
        canwire.start_line(hub, first, WantedMode(500_000).mode(first.info.capabilities)),
        canwire.start_line(hub, second, WantedMode(500_000).mode(second.info.capabilities)),
        hub.open_channel(second.board.id, second.line) as channel,
    ):
        channel.set_up(ChannelMode(receive=256, transmit=0))
        channel.activate()
        yield channel


@pytest.mark.parametrize(
    ("fields", "frame"),
    [
        ({}, Frame(0x123, b"\x11\x22")),
        ({"id": "0x1ABCDEF0", "extended": "on", "data": ""}, Frame(0x1ABCDEF0, extended=True)),
        ({"format": "remote", "dlc": "4"}, Frame(0x123, remote=True, dlc=4)),
        ({"format": "fdbrs", "data": "AA" * 12}, Frame(0x123, b"\xaa" * 12, fd=True, bit_rate_switch=True)),
    ],
)
def test_every_format_reaches_the_bus(
    client: httpx.Client, hub: canwire.Hub, fields: dict[str, str], frame: Frame
) -> None:
    with receiving(hub) as channel:
        assert client.post("/send/put", data={**GOOD, **fields}).status_code == 200
        answer = client.post("/send/now", data={"number": "1"})
        assert answer.status_code == 200, answer.text
        assert channel.receive(LONG_S) == frame


def test_a_line_that_does_not_run_is_told(client: httpx.Client) -> None:
    client.post("/send/put", data=GOOD)
    answer = client.post("/send/now", data={"number": "1"})
    assert answer.status_code == 409
    assert "does not run" in answer.json()["message"]


@pytest.fixture
def view() -> str:
    return "send"


def test_in_the_browser_by_hand_by_key_and_in_a_cycle(page: Page, hub: canwire.Hub) -> None:
    with receiving(hub) as channel:
        page.get_by_role("button", name="New").click()
        page.get_by_label("Identifier, hex").fill("999")
        page.get_by_label("Data bytes, hex").fill("AB")
        page.get_by_label("Key").fill("k")
        page.get_by_label("Cycle, ms").fill("20")
        page.get_by_label("How often").fill("5")
        page.get_by_role("button", name="Keep").click()
        page.get_by_text("999 is out of range: 0 to 7FF.").wait_for()
        page.get_by_label("Identifier, hex").fill("321")
        held: list[Route] = []
        page.route("**/send/put", lambda route: held.append(route))
        with page.expect_request("**/send/put"):
            page.get_by_label("Identifier, hex").press("Enter")
        page.keyboard.press("Enter")  # before the answer: it does nothing twice
        page.get_by_label("Key").focus()
        assert len(held) == 1
        held[0].continue_()
        page.locator("#row-dialog").wait_for(state="hidden")
        page.get_by_role("button", name="Send 1").click()
        assert channel.receive(LONG_S) == Frame(0x321, b"\xab")
        page.keyboard.press("k")
        assert channel.receive(LONG_S) == Frame(0x321, b"\xab")
        page.get_by_role("button", name="Cycle 1").click()
        assert [channel.receive(LONG_S) for _ in range(5)] == [Frame(0x321, b"\xab")] * 5
        page.get_by_role("cell", name="7", exact=True).wait_for()


@pytest.mark.finding("page 10")
def test_alone_on_the_bus_nothing_counts_as_sent_and_nothing_stale_goes_out(
    client: httpx.Client, hub: canwire.Hub
) -> None:
    first, second = canwire.find_lines(hub, "can0")[:2]
    with canwire.start_line(hub, first, WantedMode(500_000).mode(first.info.capabilities)):
        client.post("/send/put", data={**GOOD, "cycle": "1"})
        client.post("/send/start", data={"number": "1"})
        while "nobody has acknowledged" not in (listed := client.get("/send/list").text):
            pass
        assert '<td class="number counted bad" data-label="Sent">0' in listed.replace("\n", "")
        assert client.post("/send/stop", data={"number": "1"}).status_code == 200
        with (
            hub.open_channel(second.board.id, second.line) as channel,
            hub.open_channel(first.board.id, first.line) as sending,
        ):
            channel.set_up(ChannelMode(receive=256, transmit=0))
            channel.activate()
            sending.set_up(ChannelMode(receive=1, transmit=8))
            sending.activate()
            with canwire.start_line(hub, second, WantedMode(500_000).mode(second.info.capabilities)):
                sending.send(Frame(0x7FF))
                came = [channel.receive(LONG_S)]
                while came[-1] is not None and came[-1].id != 0x7FF:
                    came.append(channel.receive(LONG_S))
    assert len(came) <= 2  # the one that the controller had, at most


@pytest.mark.finding("page B4")
def test_a_list_is_saved_and_loaded(client: httpx.Client) -> None:
    client.post("/send/put", data={**GOOD, "cycle": "10", "key": "q", "comment": "ä"})
    client.post("/send/put", data={**GOOD, "format": "remote", "dlc": "4"})
    saved = client.get("/send/file").text
    for number in ("1", "2"):
        client.post("/send/remove", data={"number": number})
    answer = client.post("/send/load", data={"list": saved})
    assert answer.json()["message"] == "2 rows were added."
    assert client.get("/send/file").text == saved


@pytest.mark.parametrize(
    "text", ["", "{}", "[]", '{"what": "canwire transmit list", "rows": [{"id": "1"}]}', "x" * 70_000]
)
def test_a_file_that_is_no_list_adds_nothing(client: httpx.Client, text: str) -> None:
    assert client.post("/send/load", data={"list": text}).status_code in (409, 422)
    assert "data-row" not in client.get("/send/list").text
