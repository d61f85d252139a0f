"""One end of a relay: a connection between two machines that carries the connections of many programs."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import Awaitable, Callable

from canwire.errors import BadMessage
from canwire.hub.links.network.relay.coding import ALIVE, CLOSE, DATA, LARGEST, OPEN, Decoder, Encoder, Said

ALIVE_S = 1.0  # between two signs of life
SILENT_S = (
    6.0  # over half a lease, so that both ends of a link take it as a cut (cuts/silence.py), and below one
)
CONNECTIONS = 256  # of programs, through one relay
_CHUNK = 16_384  # bytes of one program before it is the next one's turn
_CONNECT_S = 2.0
_WAITING = 4 << 20  # bytes that may wait for a program that does not read; more than a link has under way
_UNSENT = 16_384  # bytes that wait in the system; the others wait where they are still compressed together

Connect = Callable[[], Awaitable[tuple[asyncio.StreamReader, asyncio.StreamWriter]]]


class End:
    """Carries connections of programs over `wire` until it breaks, is silent for SILENT_S, or sends invalid data.

    `connect` makes a connection for each one that the other end opens; without it the other end opens none.
    """

    def __init__(
        self, reader: asyncio.StreamReader, wire: asyncio.StreamWriter, connect: Connect | None = None
    ) -> None:
        self._reader, self._wire, self._connect = reader, wire, connect
        self._encoder, self._decoder = Encoder(), Decoder()
        self._programs: dict[int, asyncio.StreamWriter] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._last = 0
        self._turn = asyncio.Lock()
        prompt(wire)

    @property
    def carries(self) -> int:
        """The number of programs' connections."""
        return len(self._programs)

    async def run(self) -> None:
        """Carry until the end, and close all connections then; raises BadMessage, OSError, TimeoutError."""
        self._start(self._live())
        try:
            while data := await asyncio.wait_for(self._reader.read(_CHUNK), SILENT_S):
                for said in self._decoder.take(data):
                    await self._obey(said)
        finally:
            for task in self._tasks:
                task.cancel()
            for writer in (*self._programs.values(), self._wire):
                writer.transport.abort()
            self._programs.clear()

    async def open(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Carry a program's connection from now on."""
        if self.carries >= CONNECTIONS:
            writer.transport.abort()
            return
        number = self._free_number()
        self._programs[number] = writer
        prompt(writer)
        with contextlib.suppress(OSError):
            await self._say(Said(OPEN, number))
            self._start(self._carry(number, reader))
            return
        self._close(number)

    def _free_number(self) -> int:
        self._last = (self._last + 1) % (LARGEST + 1)
        while self._last in self._programs:
            self._last = (self._last + 1) % (LARGEST + 1)
        return self._last

    def _start(self, work: Awaitable[None]) -> None:
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _say(self, said: Said) -> None:
        """Compress and send; in turns, so that little waits here that a later sign of life would have to wait for."""
        async with self._turn:
            self._wire.write(self._encoder.encode(said))
            await self._wire.drain()

    async def _live(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                await self._say(Said(ALIVE, 0))
                await asyncio.sleep(ALIVE_S)

    async def _carry(self, number: int, reader: asyncio.StreamReader) -> None:
        """Everything that comes from one program, to the other end."""
        with contextlib.suppress(OSError):
            while data := await reader.read(_CHUNK):
                await self._say(Said(DATA, number, data))
        writer = self._programs.pop(number, None)
        if writer is not None:
            writer.transport.abort()
            with contextlib.suppress(OSError):
                await self._say(Said(CLOSE, number))

    async def _obey(self, said: Said) -> None:
        if said.kind == OPEN:
            await self._open_here(said.number)
        elif said.kind == CLOSE:
            self._close(said.number)
        elif said.kind == DATA:
            writer = self._programs.get(said.number)
            if writer is None:
                return  # it was closed here meanwhile
            writer.write(said.data)
            if writer.transport.get_write_buffer_size() > _WAITING:
                self._close(said.number)
                self._refuse(said.number)

    async def _open_here(self, number: int) -> None:
        if self._connect is None or number in self._programs or self.carries >= CONNECTIONS:
            raise BadMessage(f"a relay opened connection {number}, which it may not, beside {self.carries}")
        try:
            reader, writer = await asyncio.wait_for(self._connect(), _CONNECT_S)
        except OSError:
            self._refuse(number)
            return
        self._programs[number] = writer
        prompt(writer)
        self._start(self._carry(number, reader))

    def _refuse(self, number: int) -> None:
        """Have the other end close it. This end keeps reading meanwhile: if both only wrote, neither would end."""
        self._start(self._told_closed(number))

    async def _told_closed(self, number: int) -> None:
        with contextlib.suppress(OSError):
            await self._say(Said(CLOSE, number))

    def _close(self, number: int) -> None:
        writer = self._programs.pop(number, None)
        if writer is not None:
            writer.close()  # after what it still has to write


def prompt(writer: asyncio.StreamWriter) -> None:
    """Send small messages immediately, and leave little to the system: what waits there cannot be compressed."""
    end = writer.get_extra_info("socket")
    end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if hasattr(socket, "TCP_NOTSENT_LOWAT"):
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, _UNSENT)
    writer.transport.set_write_buffer_limits(high=0)
