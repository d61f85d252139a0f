"""An event loop of asyncio in a thread, for the two ends of a relay."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any, TypeVar
from weakref import WeakSet

from canwire.hub.links.network.session.door import host_and_port

_AGAIN_S = 0.1
T = TypeVar("T")
Accept = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None] | None]


class Running:
    """Runs coroutines until `close`."""

    def __init__(self, name: str) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name=name, daemon=True)
        self._thread.start()
        self._servers: list[asyncio.Server] = []
        self._accepted: WeakSet[asyncio.StreamWriter] = WeakSet()

    def listen(self, endpoint: str, accept: Accept) -> None:
        """Listen at an endpoint such as tcp/127.0.0.1:7448, in the loop; raises BadValue, OSError."""

        def accepted(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> Awaitable[None] | None:
            self._accepted.add(writer)
            return accept(reader, writer)

        async def begin() -> None:
            host, port = host_and_port(endpoint)
            self._servers.append(await asyncio.start_server(accepted, host, port))

        self.run(begin())

    def run(self, work: Coroutine[Any, Any, T]) -> T:
        """Carry it out in the loop, and wait; raises what it raises."""
        return asyncio.run_coroutine_threadsafe(work, self._loop).result()

    def close(self) -> None:
        """Cancel all that is left, and end the thread; a second call does nothing."""
        if self._loop.is_closed():
            return
        self.run(self._end())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    async def _end(self) -> None:
        for server in self._servers:
            server.close()
        while others := asyncio.all_tasks() - {asyncio.current_task()}:
            for task in others:
                task.cancel()
            # again after a moment: `asyncio.wait_for` of Python 3.11 can lose a cancellation
            ended, _ = await asyncio.wait(others, timeout=_AGAIN_S)
            for task in ended:
                if not task.cancelled():
                    task.exception()  # retrieved, so that asyncio does not log it
        for writer in self._accepted:  # a task that is cancelled before it begins closes nothing
            writer.transport.abort()
