"""The hub's end of relays: it listens for them, and connects each program of theirs to the hub's own endpoint."""

from __future__ import annotations

import asyncio
import contextlib
from functools import partial

from canwire.errors import BadMessage, BadValue, HubError
from canwire.hub.links.network.relay.coding import GREETING, LONGEST_GREETING
from canwire.hub.links.network.relay.end import End
from canwire.hub.links.network.relay.running import Running
from canwire.hub.links.network.session.door import host_and_port

RELAYS = 64
_GREETING_S = 3.0


class RelaysAtHub:
    """Listens at `endpoints` until `close`; `target` is where the hub listens, `hub` its realm and name.

    The endpoint `target` authenticates each program: a relay itself has no rights.
    Raises HubError if it cannot listen there, BadValue for a malformed endpoint.
    """

    def __init__(self, endpoints: tuple[str, ...], target: str, hub: str) -> None:
        self._target = host_and_port(target)
        self._greeting = GREETING + b" " + hub.encode() + b"\n"
        self._ends: dict[asyncio.Task[None], End] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._running = Running("canwire-relays")
        for endpoint in endpoints:
            try:
                self._running.listen(endpoint, self._accept)
            except (OSError, BadValue) as error:
                self._running.close()
                if isinstance(error, BadValue):
                    raise
                raise HubError(f"{endpoint}: cannot listen for relays there: {error}") from None

    def close(self) -> None:
        """End all connections; a second call does nothing."""
        self._running.close()

    def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.ensure_future(self._serve(reader, writer))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        try:
            writer.write(self._greeting)
            line = await asyncio.wait_for(reader.readuntil(b"\n"), _GREETING_S)
            if line.strip() != GREETING or len(line) > LONGEST_GREETING or not self._has_room():
                return
            end = self._ends[task] = End(reader, writer, partial(asyncio.open_connection, *self._target))
            await end.run()
        except (OSError, BadMessage, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
            pass  # a relay that is gone or no relay; it connects again
        finally:
            self._ends.pop(task, None)
            with contextlib.suppress(OSError):
                writer.transport.abort()

    def _has_room(self) -> bool:
        """One that carries nobody makes room for the next one."""
        if len(self._ends) >= RELAYS:
            idle = next((task for task, end in self._ends.items() if not end.carries), None)
            if idle is None:
                return False
            self._ends.pop(idle)
            idle.cancel()
        return True
