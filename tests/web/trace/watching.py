"""Viewers of the trace for tests: one without a browser, and a tab."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy
from websockets.sync.client import ClientConnection, connect

import canwire
from canwire import ChannelMode, Frame, WantedMode
from canwire.web.server import Site
from canwire.web.trace.store.rows import row_dtype
from tests.hubs import LONG_S
from tests.web.conftest import at, tab

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Page


@contextmanager
def sender(hub: canwire.Hub, bus: str = "can0") -> Iterator[canwire.HubChannel]:
    """Two lines of the bus run; this channel sends from the first of them."""
    first, second = canwire.find_lines(hub, bus)[:2]
    with (
        canwire.start_line(hub, first, WantedMode(500_000).mode(first.info.capabilities)),
        canwire.start_line(hub, second, WantedMode(500_000).mode(second.info.capabilities)),
        hub.open_channel(first.board.id, first.line) as channel,
    ):
        channel.set_up(ChannelMode(receive=8, transmit=256))
        channel.activate()
        yield channel


class Watching:
    """A viewer without a browser: it asks for the rows after those that it has."""

    def __init__(self, socket: ClientConnection, lines: list[str], **look: Any) -> None:
        self.socket = socket
        self.rows = numpy.zeros(0, row_dtype())
        self.lines: list[dict[str, Any]] = []
        self.head: dict[str, Any] = {}
        self.look(lines, **look)

    def look(self, lines: list[str], **look: Any) -> None:
        """Look anew."""
        self.rows = self.rows[:0]
        self.socket.send(json.dumps({"look": {"number": 1, "lines": lines, **look}, "ask": self._asked()}))

    def until(self, enough: Callable[[Watching], object]) -> None:
        while not enough(self):
            self.take(self.socket.recv(LONG_S))
            self.ask()

    def ask(self, **asked: Any) -> None:
        self.socket.send(json.dumps({"ask": {**self._asked(), **asked}}))

    def take(self, message: str | bytes) -> None:
        assert isinstance(message, bytes)
        length = int.from_bytes(message[:4], "little")
        self.head = json.loads(message[8 : 8 + length])
        self.lines = self.head.get("lines", self.lines)
        came = numpy.frombuffer(message, row_dtype(), self.head["rows"], 8 + length)
        if self.head["at"] == self.head["gone"] + len(self.rows):
            self.rows = numpy.concatenate((self.rows, came))

    @property
    def frames(self) -> list[Frame]:
        return [
            canwire.frame_of_record(row["record"].tobytes())
            for row in self.rows
            if row["record"]["info"] & 0xFF == 0
        ]

    @property
    def listening(self) -> bool:
        return bool(self.lines) and all(line["open"] and not line["trouble"] for line in self.lines)

    def _asked(self) -> dict[str, int]:
        return {"at": self.head.get("gone", 0) + len(self.rows), "rows": 4096}


@contextmanager
def watching(site: Site, lines: list[str], **look: Any) -> Iterator[Watching]:
    """Its taps are open."""
    with connect(f"ws://127.0.0.1:{site.port}/trace/live", max_size=None) as socket:
        made = Watching(socket, lines, **look)
        made.until(lambda one: one.listening)
        yield made


def rows_with(page: Page, **cells: str) -> Locator:
    """The rows in sight with these texts in these columns: elsewhere in a row a time may have the same digits."""
    found = page.locator("#body .trace-row:not([hidden])")
    for column, text in cells.items():
        found = found.filter(has=page.locator(f".c-{column}", has_text=text))
    return found


@contextmanager
def tab_on_trace(browser: Browser, site: Site, *addresses: str) -> Iterator[Page]:
    """A tab that hears these lines alone already."""
    with tab(browser, at(site, "trace")) as page:
        for address in addresses:
            page.locator("#lines").get_by_label(address).wait_for()
        checked = page.locator("#lines input:checked").evaluate_all("boxes => boxes.map(box => box.value)")
        for other in set(checked).difference(addresses):
            page.locator("#lines").get_by_label(other).uncheck()
        for address in addresses:
            page.locator("#lines").get_by_label(address).check()
        page.locator("body[data-listening=yes]").wait_for()
        yield page
