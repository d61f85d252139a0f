"""The trace: what the server sends, and what the page makes of it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import pytest
from websockets.exceptions import ConnectionClosedError
from websockets.sync.client import ClientConnection, connect

import canwire
from canwire import ChannelMode, Frame, WantedMode
from canwire.web.server import Site
from canwire.web.trace.feed import HEAD
from canwire.web.trace.history import ROW_BYTES
from tests.hubs import LONG_S
from tests.web.conftest import holds, tab

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Browser, Page


@contextmanager
def sender(hub: canwire.Hub) -> Iterator[canwire.HubChannel]:
    """Two lines of can0 run; this channel sends from the first of them."""
    first, second = canwire.find_lines(hub, "can0")[:2]
    with (
        canwire.start_line(hub, first, WantedMode(500_000).mode(first.info.capabilities)),
        canwire.start_line(hub, second, WantedMode(500_000).mode(second.info.capabilities)),
        hub.open_channel(first.board.id, first.line) as channel,
    ):
        channel.set_up(ChannelMode(receive=8, transmit=256))
        channel.activate()
        yield channel


class Watching:
    """A viewer without a browser."""

    def __init__(self, socket: ClientConnection, lines: list[str], backlog: int = 0) -> None:
        self.socket = socket
        self.rows: list[bytes] = []
        self.skipped = self.lost = 0
        self.lines: list[dict[str, Any]] = []
        self.socket.send(json.dumps({"watch": lines, "backlog": backlog}))

    def until(self, enough: Any) -> None:
        while not enough(self):
            self.take(self.socket.recv(LONG_S))

    def take(self, message: str | bytes) -> None:
        if isinstance(message, str):
            self.lines = json.loads(message)["lines"]
            return
        version, count, skipped, lost, _ = HEAD.unpack_from(message)
        assert version == 1
        assert len(message) == HEAD.size + count * ROW_BYTES
        self.skipped, self.lost = int(skipped), int(lost)
        self.rows += [
            message[HEAD.size + k * ROW_BYTES : HEAD.size + (k + 1) * ROW_BYTES] for k in range(count)
        ]

    @property
    def frames(self) -> list[Frame]:
        return [canwire.frame_of_record(row[:80]) for row in self.rows if row[12] == 0]


@contextmanager
def watching(site: Site, lines: list[str], backlog: int = 0) -> Iterator[Watching]:
    with connect(f"ws://127.0.0.1:{site.port}/trace/live", max_size=None) as socket:
        made = Watching(socket, lines, backlog)
        made.until(
            lambda one: [line["bus"] for line in one.lines] == ["can0"] * len(lines)
        )  # its taps are open
        yield made


@pytest.mark.conforms("PG-01", "PG-02")
def test_two_viewers_see_every_frame_once(site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    frames = [Frame(number, bytes([number & 0xFF])) for number in range(200)]
    with watching(site, [address]) as one, watching(site, [address]) as other, sender(hub) as channel:
        for frame in frames:
            channel.send(frame, timeout=LONG_S)
        for viewer in (one, other):
            viewer.until(lambda one: len(one.frames) >= len(frames))
            assert viewer.frames == frames
            assert (viewer.lost, viewer.skipped) == (0, 0)


def test_a_late_viewer_gets_the_past_it_asks_for(site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with watching(site, [address]) as first, sender(hub) as channel:
        for number in range(20):
            channel.send(Frame(number), timeout=LONG_S)
        first.until(lambda one: len(one.frames) == 20)
        with watching(site, [address], backlog=1000) as late:
            late.until(lambda one: len(one.frames) == 20)


@pytest.mark.parametrize(
    "told",
    [
        "",
        "[]",
        "{}",
        '{"watch": 7}',
        '{"watch": [7]}',
        '{"watch": [], "backlog": -1}',
        "{" * 5000,
        "x" * 20_000,
    ],
)
@pytest.mark.conforms("PG-01")
def test_a_viewer_that_talks_nonsense_is_let_go(steady: Site, told: str) -> None:
    with connect(f"ws://127.0.0.1:{steady.port}/trace/live") as socket:
        socket.send(told)
        with pytest.raises(ConnectionClosedError) as closed:
            socket.recv(LONG_S)
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code in (1003, 1009)


def test_a_board_that_is_not_there_is_named(site: Site) -> None:
    with connect(f"ws://127.0.0.1:{site.port}/trace/live") as socket:
        viewer = Watching(socket, ["HW999999:0"])
        viewer.until(lambda one: one.lines and one.lines[0]["trouble"])
    assert "HW999999:0" in viewer.lines[0]["trouble"]


def test_the_log_has_every_frame_as_candump_writes_it(
    site: Site, client: httpx.Client, hub: canwire.Hub
) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    frames = [Frame(0x123, b"\x11\x22"), Frame(0x12345678, extended=True), Frame(0x55, bytes(12), fd=True)]
    with watching(site, [address]) as viewer, sender(hub) as channel:
        for frame in frames:
            channel.send(frame, timeout=LONG_S)
        viewer.until(lambda one: len(one.frames) == len(frames))
    answer = client.get("/trace/log", params={"lines": address})
    assert answer.headers["x-canwire-lost"] == "0"
    lines = [canwire.parse_log_line(line) for line in answer.text.splitlines()]
    assert [line.content for line in lines] == frames
    assert {line.interface for line in lines} == {"can0"}
    assert {line.direction for line in lines} == {"T"}


@pytest.mark.parametrize("lines", ["", "../etc", "HW1"])
def test_a_log_of_no_line_is_refused(asker: httpx.Client, lines: str) -> None:
    assert asker.get("/trace/log", params={"lines": lines}).status_code == 422


@pytest.mark.parametrize("record", ["", "00", "zz" * 80, "ff" * 80, "00" * 81])
def test_a_row_that_is_no_record_is_refused(asker: httpx.Client, record: str) -> None:
    assert asker.get("/trace/row", params={"record": record}).status_code == 422


@contextmanager
def tab_on_trace(browser: Browser, site: Site, address: str) -> Iterator[Page]:
    """A tab that hears this line alone already."""
    with tab(browser, site.address) as page:
        page.goto(f"{site.url}trace")
        box = page.get_by_label(address)
        box.wait_for()
        for other in page.locator("#lines input:checked").all():
            if other.input_value() != address:
                other.uncheck()
        box.check()
        page.locator("body[data-listening=yes]").wait_for()
        yield page


def test_rows_open_to_their_bits(browser: Browser, site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        channel.send(Frame(0x12345678, b"\xde\xad\xbe\xef", extended=True), timeout=LONG_S)
        page.locator("#body .trace-row", has_text="DE AD BE EF").wait_for()
        page.locator("#body").focus()
        page.keyboard.press("Home")
        page.keyboard.press("Enter")
        page.locator(".wire svg .level").first.wait_for()
        assert page.locator(".wire rect.stuff").count() > 0
        page.keyboard.press("Escape")
        page.locator("#details").wait_for(state="hidden")


def test_an_error_opens_to_the_frame_that_was_destroyed_and_its_flag(
    browser: Browser, site: Site, hub: canwire.Hub
) -> None:
    """The sender alone is not acknowledged; its frame goes out once a second line joins."""
    first, second = canwire.find_lines(hub, "can0")[:2]
    with (
        canwire.start_line(hub, first, WantedMode(500_000).mode(first.info.capabilities)),
        hub.open_channel(first.board.id, first.line) as channel,
        tab_on_trace(browser, site, first.address) as page,
    ):
        channel.set_up(ChannelMode(receive=8, transmit=8))
        channel.activate()
        channel.send(Frame(0x123, b"\x55"))
        page.locator("#body .trace-row", has_text="ack error").first.wait_for()
        with canwire.start_line(hub, second, WantedMode(500_000).mode(second.info.capabilities)):
            page.locator("#filter").fill("error")
            page.locator("#filter").press("Enter")
            page.locator("#body").focus()
            page.keyboard.press("Home")
            page.keyboard.press("Enter")
            page.get_by_role("heading", name="ack error").wait_for()
            page.locator("#filter").fill("frame")
            page.locator("#filter").press("Enter")
            page.locator("#body .trace-row:not([hidden])", has_text="55").wait_for()
            page.locator("#filter").fill("error")
            page.locator("#filter").press("Enter")
            page.locator("#body").focus()
            page.keyboard.press("Home")
            page.keyboard.press("Enter")
            page.locator(".wire rect.error").first.wait_for()
            assert "123#55" in page.locator(".wire figcaption").inner_text()


def test_one_row_for_each_identifier_counts_and_marks_what_changed(
    browser: Browser, site: Site, hub: canwire.Hub
) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        page.get_by_role("button", name="By identifier").click()
        for number in range(5):
            for identifier in (0x200, 0x100):
                channel.send(Frame(identifier, bytes([7, number])), timeout=LONG_S)
        rows = page.locator("#body .trace-row:not([hidden])", has_text="07")
        for place in (0, 1):
            rows.nth(place).locator(".c-count", has_text="5").wait_for()
        assert [row.locator(".c-id").inner_text() for row in rows.all()] == ["100", "200"]
        assert rows.first.locator("b").all_inner_texts() == ["04"]


def test_pause_search_and_what_is_remembered(browser: Browser, site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        channel.send(Frame(0x101), timeout=LONG_S)
        channel.send(Frame(0x102), timeout=LONG_S)
        page.locator("#shown", has_text="2").wait_for()
        page.locator("#body").focus()
        page.keyboard.press("Space")
        page.get_by_role("button", name="Go on").wait_for()
        channel.send(Frame(0x103), timeout=LONG_S)
        page.locator("#kept", has_text="3").wait_for()
        assert page.locator("#shown").inner_text() == "2"
        page.get_by_role("button", name="Go on").click()
        page.locator("#shown", has_text="3").wait_for()
        page.keyboard.press("/")
        page.keyboard.type("102")
        page.keyboard.press("Enter")
        page.locator('#body .trace-row[aria-selected="true"]', has_text="102").wait_for()
        page.locator("#search").fill("nothing like it")
        page.keyboard.press("Enter")
        page.get_by_text("is nowhere in these rows").wait_for()
        page.locator("#filter").fill("zzz")
        page.locator("#filter").press("Enter")
        page.get_by_text("“zzz” is no identifier, range or word of a filter.").wait_for()
        page.locator("#filter").fill("!102")
        page.locator("#filter").press("Enter")
        page.locator("#shown", has_text="2").wait_for()
        page.reload()
        holds(page.locator("#filter"), "!102")
        page.locator("#shown", has_text="2").wait_for()  # from the server's history


@pytest.mark.conforms("PG-04")
def test_a_viewer_that_does_not_read_slows_nobody_and_learns_what_it_missed(
    site: Site, hub: canwire.Hub
) -> None:
    """Rows are put into the history directly: more than any socket's buffer holds."""
    address = canwire.find_lines(hub, "can0")[0].address
    with watching(site, [address]) as reading, watching(site, [address]) as sleeping:
        tracing = site.desk.kept["trace"]
        total = 0
        for _ in range(80):
            tracing.history.append(canwire.frames_to_array([Frame(1, bytes(8))] * 4000), 0)
            total += 4000
            reading.until(lambda one, total=total: len(one.rows) + one.skipped >= total)
        assert (len(reading.rows), reading.skipped) == (total, 0)
        sleeping.until(lambda one: len(one.rows) + one.skipped >= total)
        assert sleeping.skipped > 0
