"""An event loop of asyncio in a thread, for the two ends of a relay."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Coroutine
from typing import Any, TypeVar

from canwire.hub.links.network.session.door import host_and_port

T = TypeVar("T")


class Running:
    """Runs coroutines until `close`."""

    def __init__(self, name: str) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name=name, daemon=True)
        self._thread.start()

    def run(self, work: Coroutine[Any, Any, T]) -> T:
        """Carry it out in the loop, and wait; raises what it raises."""
        return asyncio.run_coroutine_threadsafe(work, self._loop).result()

    def close(self) -> None:
        """Cancel all that is left, and end the thread; a second call does nothing."""
        if self._loop.is_closed():
            return
        self.run(_cancel_others())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()


async def listen(endpoint: str, accept: Any) -> asyncio.Server:
    """A server at an endpoint such as tcp/127.0.0.1:7448; raises BadValue, OSError."""
    host, port = host_and_port(endpoint)
    return await asyncio.start_server(accept, host, port)


async def _cancel_others() -> None:
    others = asyncio.all_tasks() - {asyncio.current_task()}
    for task in others:
        task.cancel()
    await asyncio.gather(*others, return_exceptions=True)
