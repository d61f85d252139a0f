"""Rows to one viewer: it reads the history at its own pace, and what it was too slow for is skipped and counted.

The viewer says {"watch": [addresses], "backlog": rows}. It gets, as text, {"lines": [...]} whenever something of them
changes, and, as bytes, passages: a head of 32 bytes (version 1, count, both 32 bits; skipped, lost and total as
64-bit floats; little-endian) and `count` rows of 88 bytes.
"""

from __future__ import annotations

import asyncio
import json
import struct
from typing import TYPE_CHECKING, Any

from starlette.concurrency import run_in_threadpool

from canwire.web.live import converse

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from canwire.web.trace.history import History
    from canwire.web.trace.taps import Taps

HEAD = struct.Struct("<IIddd")
VERSION = 1
MOST_ROWS = 4096  # in a message
BEHIND = 65_536  # rows: who is further behind goes on with the newest ones
PACE_S = 0.02
TOLD_S = 1.0  # between two looks at what is lost
MOST_LINES = 64


class Feed:
    """One viewer's."""

    def __init__(self, socket: WebSocket, history: History, taps: Taps) -> None:
        self._socket = socket
        self._history = history
        self._taps = taps
        self._grown = asyncio.Event()
        self._watch: list[str] = []
        self._cursor = history.total
        self._skipped = 0
        self._told: list[Any] = []

    async def run(self) -> None:
        """Until the viewer has gone."""
        loop = asyncio.get_running_loop()

        def grown() -> None:
            loop.call_soon_threadsafe(self._grown.set)

        self._history.listen(grown)
        try:
            await converse(self._socket, self._speak, self._hear)
        finally:
            self._history.unlisten(grown)
            self._taps.want(self, ())

    def _hear(self, told: dict[str, Any]) -> None:
        """What the viewer watches; ValueError for anything else."""
        watch, backlog = told["watch"], told.get("backlog", 0)
        if not isinstance(watch, list) or len(watch) > MOST_LINES:
            raise ValueError("watch")
        if not all(isinstance(one, str) and 0 < len(one) <= 80 for one in watch):
            raise ValueError("watch")
        if not isinstance(backlog, int) or not 0 <= backlog <= BEHIND:
            raise ValueError("backlog")
        self._watch = watch
        if backlog:
            self._cursor = max(0, self._history.total - backlog)
        self._taps.want(self, watch)
        self._told = []
        self._grown.set()

    async def _speak(self) -> None:
        while True:
            await self._tell()
            try:
                await asyncio.wait_for(self._grown.wait(), TOLD_S)
            except TimeoutError:
                continue
            self._grown.clear()
            while await self._send_passage():
                pass
            await asyncio.sleep(PACE_S)  # what comes meanwhile goes in one message

    async def _tell(self) -> None:
        """About the lines, if it is new."""
        lines = await run_in_threadpool(self._taps.watched)
        told = [line._asdict() for line in lines if line.address in self._watch]
        if told != self._told:
            self._told = told
            await self._socket.send_text(json.dumps({"lines": told}))

    async def _send_passage(self) -> bool:
        """The next rows; was that all it could take at once?"""
        total = self._history.total
        if total - self._cursor > BEHIND:
            self._skipped += total - MOST_ROWS - self._cursor
            self._cursor = total - MOST_ROWS
        lines = [*self._taps.indices(self._watch), 0xFFFF]
        rows, skipped, after = self._history.since(self._cursor, MOST_ROWS, lines)
        self._skipped += skipped
        more = after - self._cursor == MOST_ROWS
        self._cursor = after
        lost = sum(line["lost"] for line in self._told)
        if len(rows):
            head = HEAD.pack(VERSION, len(rows), self._skipped, lost, total)
            await self._socket.send_bytes(head + rows.tobytes())
        return more
