"""CanCheck to one viewer: {"main": ..., "windows": [...]} whenever something of it changes, as often as it reads."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING, Any

from starlette.concurrency import run_in_threadpool

from canwire import HubLost
from canwire.web.cancheck.told import key_of, told_main, told_rows, told_window
from canwire.web.live import converse

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from canwire.web.cancheck.checking import Checking

PACE_S = 0.1  # what comes meanwhile goes in one message
LOOK_S = 1.0  # between two looks at what other programs have changed


class Feed:
    """One viewer's: it has seen the rows of each window up to some number."""

    def __init__(self, socket: WebSocket, checking: Checking) -> None:
        self._socket = socket
        self._checking = checking
        self._changed = asyncio.Event()
        self._seen: dict[str, int] = {}
        self._told = ""

    async def run(self) -> None:
        """Until the viewer has gone."""
        loop = asyncio.get_running_loop()

        def changed() -> None:
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
        """The message, "" if there is nothing new."""
        program = self._checking.program
        windows = program.windows
        try:
            told = {"main": told_main(program), "windows": [told_window(one) for one in windows]}
        except HubLost:
            return ""
        rows = {key_of(one): told_rows(one, self._seen.get(key_of(one), 0)) for one in windows}
        news = any(self._seen.get(key) != one["total"] for key, one in rows.items())
        # what was cleared is told, too
        state = json.dumps([told, [(key, one["first"]) for key, one in rows.items()]])
        if state == self._told and not news:
            return ""
        self._told = state
        self._seen = {key: one["total"] for key, one in rows.items()}
        shown: list[dict[str, Any]] = [{**one, **rows[one["key"]]} for one in told["windows"]]  # type: ignore[dict-item]
        return json.dumps({"main": told["main"], "windows": shown})
