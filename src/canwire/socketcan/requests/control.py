"""Requests of shims: one message on a separate connection, one answer."""

from __future__ import annotations

import errno
import socket
import struct
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple, Protocol

from canwire import CanwireError
from canwire.socketcan.loop import READABLE, URGENT

if TYPE_CHECKING:
    from canwire.socketcan.loop import Loop

LARGEST_REQUEST = 1 << 21
_REQUEST = struct.Struct("<Iiiii")
_RESULT = struct.Struct("<q")
_BACKLOG = 512


class Request(NamedTuple):
    """struct request of shim/shim.h, and the data after it; `program` is the name of the calling program."""

    operation: int
    slot: int
    a: int
    b: int
    data: bytes
    program: str
    process: int
    thread: int


class Asked:
    """One request to be answered, now or later; the calling process waits."""

    def __init__(self, loop: Loop, connection: socket.socket) -> None:
        self._loop = loop
        self._connection = connection
        self.answered = False
        self.hold: Callable[[Callable[[], object]], object] | None = None  # decides when an answer is given

    def answer(self, result: int, data: bytes = b"", descriptor: int | None = None) -> None:
        """`result` below 0 is an errno. A program that has ended meanwhile needs no answer."""
        self.answered = True
        if self.hold is None:
            self._give(result, data, descriptor)
        else:
            self.hold(lambda: self._give(result, data, descriptor))

    def when_gone(self, call: Callable[[], object]) -> None:
        """Calls `call` when the calling process was interrupted or has ended."""

        def gone(_: int) -> None:
            self._loop.forget(self._connection.fileno())
            self._connection.close()
            call()

        self._loop.watch(self._connection.fileno(), READABLE | URGENT, gone)

    def _give(self, result: int, data: bytes, descriptor: int | None) -> None:
        self._loop.forget(self._connection.fileno())
        try:
            message = [_RESULT.pack(result), data]
            if descriptor is None:
                self._connection.sendmsg(message)
            else:
                socket.send_fds(self._connection, message, [descriptor])
        except ConnectionError:
            pass
        finally:
            self._connection.close()


class Unasked:
    """Replaces Asked for a message that was sent in a way without an answer."""

    def answer(self, result: int, data: bytes = b"", descriptor: int | None = None) -> None:
        """Nothing: there is no receiver."""


class Answered(Protocol):
    """Asked, or Unasked."""

    def answer(self, result: int, data: bytes = b"", descriptor: int | None = None) -> None: ...


Answering = Callable[[Request, Asked], object]


class Control:
    """Listens at `path`; `answering` gets each request, and raises OSError or CanwireError for one that fails.

    Any other exception is reported to `fault`, with the name of the program; only that request fails.
    """

    def __init__(
        self, loop: Loop, path: str, answering: Answering, fault: Callable[[str, Exception], object]
    ) -> None:
        self._loop = loop
        self._answering = answering
        self._fault = fault
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET | socket.SOCK_NONBLOCK)
        self._listener.bind(path)
        self._listener.listen(_BACKLOG)
        loop.watch(self._listener.fileno(), READABLE | URGENT, self._accept)

    def close(self) -> None:
        self._loop.forget(self._listener.fileno())
        self._listener.close()

    def _accept(self, _: int) -> None:
        try:
            connection, _address = self._listener.accept()
        except BlockingIOError:
            return
        connection.setblocking(False)
        self._loop.watch(connection.fileno(), READABLE | URGENT, lambda _: self._receive(connection))

    def _receive(self, connection: socket.socket) -> None:
        self._loop.forget(connection.fileno())
        try:
            message = connection.recv(LARGEST_REQUEST)
        except OSError:
            message = b""
        if len(message) < _REQUEST.size:
            connection.close()
            return
        asked = Asked(self._loop, connection)
        operation, slot, a, b, thread = _REQUEST.unpack_from(message)
        data = message[_REQUEST.size :]
        process = _process_of(connection)
        request = Request(operation, slot, a, b, data, _name_of(process), process, thread)
        try:
            self._answering(request, asked)
        except Exception as error:
            if not isinstance(error, OSError | CanwireError):
                self._fault(f"{request.program}, request {operation}", error)
            if not asked.answered:
                asked.answer(-(getattr(error, "errno", None) or errno.EIO))


def _process_of(connection: socket.socket) -> int:
    """The process at the other end."""
    credentials = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12)
    process: int = struct.unpack("<iII", credentials)[0]
    return process


def _name_of(process: int) -> str:
    try:
        with open(f"/proc/{process}/comm", encoding="utf-8", errors="replace") as file:
            return file.read().strip()
    except OSError:
        return f"process {process}"
