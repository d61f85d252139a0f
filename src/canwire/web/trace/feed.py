"""Sends rows to one viewer on request: nothing is queued for the viewer, so it cannot miss a row or lag behind.

The viewer sends {"look": ...} (look.py) whenever its view changes, and {"ask": ...} for the rows on its screen. Each
request gets one answer, when new rows exist, and after TOLD_S at the latest: a viewer that receives nothing for longer
knows that the server has ended. An answer is a JSON head, preceded by its length (32 bits, little-endian), `rows` rows
of 88 bytes, and, by identifier, an extra for each row (answers.py).
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from starlette.concurrency import run_in_threadpool

from canwire import BadValue
from canwire.web.live import converse
from canwire.web.trace.look import Ask, Look
from canwire.web.trace.viewing import Viewing

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

PACE_S = 0.02  # after an answer: some 35 pictures a second, each with the rows of its moment
TOLD_S = 0.5  # the longest that an answer takes


class Feed:
    """The feed of one viewer. `viewing(look, viewer, before)` makes its view; raises BadValue for a closed source."""

    def __init__(self, socket: WebSocket, viewing: Callable[[Look, object, Viewing | None], Viewing]) -> None:
        self._socket = socket
        self._open = viewing
        self._news = asyncio.Event()
        self._look: Look | None = None
        self._ask: Ask | None = None
        self._viewing: Viewing | None = None
        self._opening: asyncio.Task[Viewing] | None = None
        self._answered: object = None

    async def run(self) -> None:
        """Answer the viewer until it has left."""
        self._loop = asyncio.get_running_loop()
        try:
            await converse(self._socket, self._speak, self._hear)
        finally:
            await self._leave()

    def _hear(self, told: dict[str, Any]) -> None:
        """Handle a message of the viewer; raises ValueError for an invalid one."""
        if not told.keys() & {"look", "ask"}:
            raise ValueError("look or ask")
        look = Look.parse(told["look"]) if "look" in told else self._look
        self._ask = Ask.parse(told["ask"]) if "ask" in told else self._ask
        self._look = look
        self._news.set()

    def _grown(self) -> None:
        """Wake the feed for new rows. Called in the writer's thread; without a pending request
        there is nothing to do."""
        if self._ask is not None and not self._news.is_set():
            self._loop.call_soon_threadsafe(self._news.set)

    async def _speak(self) -> None:
        while True:
            waited = await self._waited()
            if self._look is not None and (self._viewing is None or self._viewing.look is not self._look):
                try:
                    await self._change(self._look)
                except BadValue:  # its log is closed: the viewer hears that with the lines
                    await self._socket.close()
                    return
            viewing, ask = self._viewing, self._ask
            if viewing is None or ask is None:
                continue
            message = await run_in_threadpool(self._answer, viewing, ask, waited >= TOLD_S)
            if message is None:
                continue
            if self._ask is ask:
                self._ask = None
            await self._socket.send_bytes(message)
            await asyncio.sleep(PACE_S)

    def _answer(self, viewing: Viewing, ask: Ask, anyway: bool) -> bytes | None:
        """Return the answer; None if there is nothing new, unless `anyway` requests an answer."""
        viewing.extend()
        state = ask, viewing.look, viewing.state
        if state == self._answered and not anyway:
            return None
        self._answered = state
        return viewing.answer(ask)

    async def _leave(self) -> None:
        """End the present view, and one that a thread is still making."""
        if self._opening is not None:
            await asyncio.wait((self._opening,))
            if self._opening.exception() is None:
                self._opening.result().leave()
        if self._viewing is not None:
            self._viewing.leave()

    async def _change(self, look: Look) -> None:
        before = self._viewing
        self._opening = asyncio.create_task(run_in_threadpool(self._open, look, self, before))
        self._viewing = await asyncio.shield(self._opening)  # a thread cannot be stopped
        if before is not None:
            before.unlisten()
        self._viewing.listen(self._grown)
        self._news.set()

    async def _waited(self) -> float:
        """Wait until there may be new rows; returns the seconds waited, TOLD_S if nothing happened for so long."""
        if self._ask is not None and self._viewing is not None and self._viewing.more:
            return 0.0
        try:
            async with asyncio.timeout(
                TOLD_S
            ):  # Python 3.11's wait_for loses a cancellation that comes with the news
                await self._news.wait()
        except TimeoutError:
            return TOLD_S
        self._news.clear()
        return 0.0
