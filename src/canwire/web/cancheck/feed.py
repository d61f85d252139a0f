"""Sends CanCheck's state to one viewer, {"main": ..., "windows": [...]}, after changes, as fast as the viewer reads."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING

from starlette.concurrency import run_in_threadpool

from canwire.web.cancheck.told import key_of, told_main, told_rows, told_window
from canwire.web.live import converse

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from canwire.web.cancheck.checking import Checking
    from canwire.web.words import Words

PACE_S = 0.1  # what comes meanwhile goes in one message
LOOK_S = 1.0  # between two looks at what other programs have changed


class Feed:
    """The feed of one viewer, with the number of the last row that it has received of each window."""

    def __init__(self, socket: WebSocket, checking: Checking, word: Words) -> None:
        self._socket = socket
        self._checking = checking
        self._word = word
        self._changed = asyncio.Event()
        self._seen: dict[str, int] = {}
        self._told = ""

    async def run(self) -> None:
        """Send changes until the viewer has left."""
        loop = asyncio.get_running_loop()

        def changed() -> None:
            if not self._changed.is_set():  # it is cleared before each look: nothing is overlooked
                loop.call_soon_threadsafe(self._changed.set)

        self._checking.listen(changed)
        try:
            await converse(self._socket, self._speak)
        finally:
            self._checking.unlisten(changed)

    async def _speak(self) -> None:
        while True:
            self._changed.clear()
            text = await run_in_threadpool(self._look)
            if text:
                await self._socket.send_text(text)
            await asyncio.sleep(PACE_S)
            try:
                await asyncio.wait_for(self._changed.wait(), LOOK_S)
            except TimeoutError:
                continue

    def _look(self) -> str:
        """Return the message, "" if there is nothing new."""
        windows = self._checking.program.windows
        main, states = (
            told_main(self._checking.program, self._word),
            [told_window(one, self._word) for one in windows],
        )
        rows = [told_rows(one, self._seen.get(key_of(one), 0)) for one in windows]
        totals = {key_of(one): part["total"] for one, part in zip(windows, rows, strict=True)}
        # cleared lists are reported, too
        state = json.dumps([main, states, [part["first"] for part in rows]])
        if state == self._told and totals == self._seen:
            return ""
        self._told, self._seen = state, totals
        shown = [{**one, **part} for one, part in zip(states, rows, strict=True)]
        return json.dumps({"main": main, "windows": shown})
