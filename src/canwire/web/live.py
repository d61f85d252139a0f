"""Web sockets to viewers, none of which slows another: each has a bounded queue, and what did not fit is counted."""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

MESSAGE_BYTES = 16_384  # a viewer says little
TOO_BIG, MALFORMED = 1009, 1003  # RFC 6455 7.4.1


class Outbox:
    """Messages on their way to one viewer. `put` may be called from any thread and never waits.

    When `room` messages wait, the oldest goes; `lost` counts what was in it (`rows`).
    """

    def __init__(self, room: int = 64) -> None:
        self._loop = asyncio.get_running_loop()
        self._room = room
        self._waiting: deque[tuple[str | bytes, int]] = deque()
        self._filled = asyncio.Event()
        self.lost = 0

    def put(self, message: str | bytes, rows: int = 1) -> None:
        """Queue one; `rows` is what its loss counts."""
        self._loop.call_soon_threadsafe(self._put, message, rows)

    def _put(self, message: str | bytes, rows: int) -> None:
        if len(self._waiting) >= self._room:
            self.lost += self._waiting.popleft()[1]
        self._waiting.append((message, rows))
        self._filled.set()

    async def take(self) -> str | bytes:
        """The oldest one; waits for it."""
        while not self._waiting:
            self._filled.clear()
            await self._filled.wait()
        return self._waiting.popleft()[0]


async def send(socket: WebSocket, message: str | bytes) -> None:
    """As text or as bytes; waits while the viewer does not read."""
    if isinstance(message, str):
        await socket.send_text(message)
    else:
        await socket.send_bytes(message)


async def drain(socket: WebSocket, outbox: Outbox) -> None:
    """Send whatever is put into the outbox, for ever."""
    while True:
        await send(socket, await outbox.take())


async def converse(
    socket: WebSocket,
    speak: Callable[[], Awaitable[None]],
    hear: Callable[[dict[str, Any]], None] | None = None,
) -> None:
    """Until the viewer has gone: run `speak` and give `hear` each JSON object that the viewer sends.

    A viewer that says anything else, too much of it, or what `hear` raises ValueError for, is disconnected.
    """
    await socket.accept()
    speaking = asyncio.ensure_future(_quietly(speak))
    listening = asyncio.ensure_future(_listen(socket, hear))
    try:
        await asyncio.wait((speaking, listening), return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in (speaking, listening):
            task.cancel()
        await asyncio.gather(speaking, listening, return_exceptions=True)
    for task in (speaking, listening):
        if not task.cancelled() and (error := task.exception()) is not None:
            raise error


async def _quietly(speak: Callable[[], Awaitable[None]]) -> None:
    try:
        await speak()
    except (WebSocketDisconnect, RuntimeError) as error:
        # Starlette's word for a socket that was closed while something was being sent
        if isinstance(error, RuntimeError) and "close" not in str(error):
            raise


async def _listen(socket: WebSocket, hear: Callable[[dict[str, Any]], None] | None) -> None:
    try:
        while True:
            text = await socket.receive_text()
            code = MALFORMED
            if len(text) > MESSAGE_BYTES:
                code = TOO_BIG
            elif hear is not None and isinstance(told := _parsed(text), dict):
                try:
                    hear(told)
                    continue
                except (ValueError, TypeError, KeyError):
                    pass  # malformed: said to the viewer by the code
            await socket.close(code)
            return
    except (WebSocketDisconnect, KeyError):  # KeyError: bytes where text was expected
        return


def _parsed(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None
