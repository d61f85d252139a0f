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

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Page

DBC = """VERSION ""
BU_: ECU
BO_ 291 EngineData: 8 ECU
 SG_ Speed : 0|16@1+ (0.25,0) [0|16000] "rpm" ECU
 SG_ Hot : 16|1@1+ (1,0) [0|1] "" ECU
VAL_ 291 Hot 1 "yes" 0 "no" ;
"""


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
def test_a_viewer_that_talks_nonsense_is_let_go(site: Site, told: str) -> None:
    with connect(f"ws://127.0.0.1:{site.port}/trace/live") as socket:
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
def test_a_log_of_no_line_is_refused(client: httpx.Client, lines: str) -> None:
    assert client.get("/trace/log", params={"lines": lines}).status_code == 422


@pytest.mark.parametrize("record", ["", "00", "zz" * 80, "ff" * 80, "00" * 81])
def test_a_row_that_is_no_record_is_refused(client: httpx.Client, record: str) -> None:
    assert client.get("/trace/row", params={"record": record}).status_code == 422


def test_rows_open_to_their_bits(page: Page, hub: canwire.Hub) -> None:
    page.get_by_role("link", name="Trace").click()
    with sender(hub) as channel:
        box = page.get_by_label(canwire.find_lines(hub, "can0")[0].address)
        box.check()
        page.locator("#live").wait_for(state="attached")
        row = page.locator("#body .trace-row", has_text="12345678")
        while not row.count():  # until the server listens
            channel.send(Frame(0x12345678, b"\xde\xad\xbe\xef", extended=True), timeout=LONG_S)
            page.wait_for_load_state("networkidle")
        page.locator("#pause").click()
        page.locator("#body").focus()
        page.keyboard.press("Home")
        page.keyboard.press("Enter")
        page.locator(".wire svg .level").first.wait_for()
    assert page.locator(".wire rect.stuff").count() > 0
    assert "DE AD BE EF" in row.first.inner_text()
    page.keyboard.press("Escape")
    assert page.locator("#details").is_hidden()
    page.locator("#filter").fill("zzz")
    page.locator("#filter").press("Enter")
    page.get_by_text("“zzz” is no identifier, range or word of a filter.").wait_for()
    page.locator("#filter").fill("!12345678")
    page.locator("#filter").press("Enter")
    page.locator("#empty").wait_for()
    page.reload()
    assert page.locator("#filter").input_value() == "!12345678"  # remembered
