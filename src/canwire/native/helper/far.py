"""Answers for a program that cannot receive descriptors: one on Windows, over TCP on this machine.

The helper connects to the program and sends the token from its environment, and the port on which it listens. This
first connection is for signals, and ends with the program. Each calling thread of the program opens another
connection, which begins with the token. A signal that was sent before a reply may arrive after it, so each reply
contains the number of signals sent, and its reader waits for them. ../win32/ is the other end.
"""

from __future__ import annotations

import contextlib
import hmac
import itertools
import os
import socket
import struct
import sys
import threading
from functools import partial
from typing import TYPE_CHECKING, Any

from canwire import BadMessage, Event
from canwire.native.helper.answers import Reply
from canwire.native.helper.rings import PLACE
from canwire.native.helper.serving import Helper

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import RingEnd

TOKEN = "CANWIRE_PROGRAM_TOKEN"
_LOOPBACK = "127.0.0.1"
_CALLS = b"C"
_PATIENCE_S = 10.0  # for a connection's token
_SIGNALLED, _OVER, _RING, _HEAR, _FORGET = range(1, 6)  # ../win32/win32.h
_ASIDE = struct.Struct("<II")
_PORT = struct.Struct("<H")
_REQUEST = struct.Struct("<40sII")
_REPLY = struct.Struct("<iIIII")
_NAME = struct.Struct("64s")
_LARGEST = 1 << 16


class _Heard:
    """The signal of one queue, in the form that Event.bind needs."""

    advance = None
    clock = None

    def __init__(self, descriptor: Any, told: Callable[[], None]) -> None:
        self.descriptor = descriptor
        self.over = False
        self._told = told

    def rearm(self) -> None:
        """Called when the queue is signalled: report it to the program."""
        self._told()

    def stir(self) -> None:
        """Do nothing: no wait here depends on a hub's time."""


class FarRings:
    """Passes queues by name (helper.answers.Passing), and signals over the first connection, of which it is one end."""

    def __init__(self, connection: socket.socket, process: int) -> None:
        self._connection = connection
        self._process = process
        self._numbers = itertools.count(1)
        self._heard: dict[int, _Heard] = {}
        self._rung: dict[int, Any] = {}
        self._event = Event()
        self._ending = threading.Lock()  # over whether a signal is heard or over
        self._sending = threading.Lock()
        self._said = 0

    def lend(self, end: RingEnd, value: int = 0, data: bytes = b"") -> Reply:
        """A reply that gives the program this end of a ring to use; `data` follows."""
        number = self._hearing(end.descriptor)
        lent = end.lend(partial(self._end, number))
        if end.lease.over:
            self._end(number)
        ring = end.ring
        place = PLACE.pack(lent.begin, ring.capacity, ring.record_size, end.reads, 0)
        names = [self._memory(lent.memory.fileno()), f"signal {number}"]
        if lent.peer is not None:
            self._rung[peer := next(self._numbers)] = lent.peer
            names.append(f"signal {peer}")
        return Reply(0, value, place + data, names=tuple(names))

    def said(self) -> int:
        """The number of messages sent about signals, modulo 2**32."""
        with self._sending:
            return self._said & 0xFFFFFFFF

    def watch(self, event: Event) -> Reply:
        """A reply with a signal for what this event is assigned to."""
        return Reply(names=(f"signal {self._hearing(event.signals[0].descriptor)}",))

    def tell(self) -> None:
        """Report signals to the program until it is gone; runs in a separate thread."""
        while True:
            self._event.wait()

    def obey(self) -> None:
        """Execute the program's messages about signals until it is gone."""
        with contextlib.suppress(ConnectionError):
            while message := _whole(self._connection, _ASIDE.size):
                what, number = _ASIDE.unpack(message)
                if what == _RING and number in self._rung:
                    self._rung[number].signal()
                elif what == _HEAR and number in self._heard:
                    self._begin(number, self._heard[number])
                elif what == _FORGET:
                    self._forget(number)

    def _hearing(self, descriptor: Any) -> int:
        number = next(self._numbers)
        self._heard[number] = _Heard(descriptor, partial(self._say, _SIGNALLED, number))
        return number

    def _begin(self, number: int, heard: _Heard) -> None:
        """Report signals of this number from now on, because the program knows it."""
        with self._ending:
            over = heard.over
            if not over:
                with contextlib.suppress(ValueError, OSError):  # closed meanwhile: it signals nothing more
                    self._event.bind(heard)
        if over:
            self._say(_OVER, number)

    def _end(self, number: int) -> None:
        heard = self._heard.get(number)
        if heard is not None:
            with self._ending:
                heard.over = True
                self._event.unbind(heard)
            self._say(_OVER, number)

    def _forget(self, number: int) -> None:
        heard = self._heard.pop(number, None)
        if heard is not None:
            self._event.unbind(heard)
        self._rung.pop(number, None)

    def _say(self, what: int, number: int) -> None:
        with contextlib.suppress(OSError), self._sending:  # it is gone, which `obey` finds out
            self._connection.sendall(_ASIDE.pack(what, number))
            self._said += 1

    def _memory(self, descriptor: int) -> str:
        """Return what the program opens: a handle duplicated for it, or on Linux a file that Wine shows it."""
        if sys.platform == "win32":
            import _winapi
            import msvcrt

            program = _winapi.OpenProcess(_winapi.PROCESS_DUP_HANDLE, False, self._process)
            try:
                own, given = _winapi.GetCurrentProcess(), msvcrt.get_osfhandle(descriptor)
                handle = _winapi.DuplicateHandle(own, given, program, 0, False, _winapi.DUPLICATE_SAME_ACCESS)
            finally:
                _winapi.CloseHandle(program)
            return f"handle {handle}"
        return f"file /proc/{os.getpid()}/fd/{descriptor}"


def serve_far(port: int, process: int) -> None:
    """Answer the program that listens on this port, until it has ended."""
    token = bytes.fromhex(os.environ.pop(TOKEN))
    with (
        socket.create_server((_LOOPBACK, 0)) as listener,
        socket.create_connection((_LOOPBACK, port)) as lifeline,
    ):
        lifeline.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        lifeline.sendall(token + _PORT.pack(listener.getsockname()[1]))
        rings = FarRings(lifeline, process)
        threading.Thread(target=rings.tell, daemon=True).start()
        threading.Thread(target=_accept, args=(listener, token, rings), daemon=True).start()
        rings.obey()


def _accept(listener: socket.socket, token: bytes, rings: FarRings) -> None:
    helper = Helper(rings)
    while True:
        connection, _ = listener.accept()
        threading.Thread(target=_answer_on, args=(connection, token, helper, rings), daemon=True).start()


def _answer_on(connection: socket.socket, token: bytes, helper: Helper, rings: FarRings) -> None:
    """Answer until the program closes the connection; close it if the token is wrong."""
    with connection, contextlib.suppress(ConnectionError, TimeoutError):
        connection.settimeout(_PATIENCE_S)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        hello = _whole(connection, len(token) + len(_CALLS))
        if not hmac.compare_digest(hello, token + _CALLS):
            return
        connection.settimeout(None)
        while head := _whole(connection, _REQUEST.size):
            method, number, size = _REQUEST.unpack(head)
            if size > _LARGEST:
                raise BadMessage(f"a call with {size} bytes: {_LARGEST} at most")
            data = _whole(connection, size) if size else b""
            reply = helper.answer(method.rstrip(b"\0").decode("ascii"), number, data)
            connection.sendall(_packed(reply, rings.said()))


def _packed(reply: Reply, said: int) -> bytes:
    names = b"".join(_NAME.pack(name.encode()) for name in reply.names)
    head = _REPLY.pack(reply.result, reply.value, len(reply.data), len(reply.names), said)
    return head + reply.data + names


def _whole(connection: socket.socket, size: int) -> bytes:
    """Return `size` received bytes; empty if the other end has closed the connection."""
    parts = bytearray()
    while len(parts) < size:
        more = connection.recv(size - len(parts))
        if not more:
            return b""
        parts += more
    return bytes(parts)
