"""The programs' end of a relay: programs of this machine connect to it, and one connection leads to the hub."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable

from canwire.errors import BadMessage, HubError, HubLost
from canwire.hub.links.network import keys
from canwire.hub.links.network.relay.coding import GREETING, LONGEST_GREETING
from canwire.hub.links.network.relay.end import End
from canwire.hub.links.network.relay.running import Running
from canwire.hub.links.network.session.door import host_and_port

_CONNECT_S = 5.0
_AGAIN_S = 0.3
_SILENT = "nothing was heard"  # told where a time limit has ended the wait: that error has no text


class RelayAtPrograms:
    """Listens at `local` and carries programs' connections to the hub whose end is at `endpoint`, until `close`.

    While the other end is out of reach, programs are turned away, and it is tried again; `warn` gets a line about each
    break and its end. Raises HubLost if nobody answers at first, HubError if it is no relay's end or `local` is taken.
    """

    def __init__(self, endpoint: str, local: str, warn: Callable[[str], object]) -> None:
        self._endpoint, self._warn = endpoint, warn
        self._where = host_and_port(endpoint)
        self._end: End | None = None
        self._hub = ""
        self._running = Running("canwire-relay")
        try:
            self._running.run(self._begin())
            self._listen(local)
        except BaseException:
            self._running.close()
            raise
        self.address = f"{keys.SCHEME}{self._hub}?relay={local}"

    def close(self) -> None:
        """Close all connections; a second call does nothing."""
        self._running.close()

    async def _begin(self) -> None:
        try:
            first = await self._connected()
        except OSError as error:
            raise HubLost(
                f"{self._endpoint}: no relay's end answers; is `canwire offer --relay {self._endpoint}` running "
                f"there? ({str(error) or _SILENT})"
            ) from None
        except BadMessage as error:
            raise HubError(f"{self._endpoint}: {error}") from None
        self._keeping = asyncio.ensure_future(self._keep(first))

    def _listen(self, local: str) -> None:
        try:
            self._running.listen(local, self._accept)
        except OSError as error:
            raise HubError(
                f"{local}: cannot listen there: {error}; give another endpoint (--listen)"
            ) from None

    async def _connected(self) -> End:
        reader, writer = await asyncio.wait_for(asyncio.open_connection(*self._where), _CONNECT_S)
        try:
            writer.write(GREETING + b"\n")
            self._hub = await self._greeted(reader)
            return End(reader, writer)
        except BaseException:
            writer.transport.abort()
            raise

    async def _greeted(self, reader: asyncio.StreamReader) -> str:
        """The realm and name of the hub that answers."""
        try:
            line = await asyncio.wait_for(reader.readuntil(b"\n"), _CONNECT_S)
        except (asyncio.IncompleteReadError, asyncio.LimitOverrunError):
            line = b""
        said, _, hub = line.rstrip(b"\n").rpartition(b" ")
        if said != GREETING or len(line) > LONGEST_GREETING:
            raise BadMessage("what answers there is no relay's end, or of another version of canwire")
        return hub.decode("ascii", "replace")

    async def _keep(self, end: End) -> None:
        """Carry, and connect again whenever the connection has ended."""
        while True:
            self._end = end
            try:
                await end.run()
                why = "it was ended"
            except (OSError, BadMessage) as error:
                why = str(error) or _SILENT
            self._end = None
            since_s = time.monotonic()
            self._warn(f"the relay's connection to {self._endpoint} broke: {why}; trying again")
            end = await self._again()
            self._warn(f"connected to {self._endpoint} again after {time.monotonic() - since_s:.1f} s")

    async def _again(self) -> End:
        while True:
            await asyncio.sleep(_AGAIN_S)
            with contextlib.suppress(OSError, BadMessage):
                return await self._connected()

    async def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._end is None:
            writer.transport.abort()
        else:
            await self._end.open(reader, writer)
