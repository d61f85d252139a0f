"""Web sockets to viewers. No viewer slows another: each has a task that waits while the viewer does not read.

The sender queues nothing for a viewer in the meantime: it continues with the newest data, and counts omitted data.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

MESSAGE_BYTES = 65_536  # a thousand lines and their filter
TOO_BIG, MALFORMED = 1009, 1003  # RFC 6455 7.4.1


async def converse(
    socket: WebSocket,
    speak: Callable[[], Awaitable[None]],
    hear: Callable[[dict[str, Any]], None] | None = None,
) -> None:
    """Until the viewer leaves, run `speak` and pass `hear` each JSON object that the viewer sends.

    A viewer that sends anything else, too much, or an object for which `hear` raises ValueError, is disconnected.
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
