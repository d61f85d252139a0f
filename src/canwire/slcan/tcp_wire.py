"""The TCP port of a dongle: it serves one host at a time, and closes the connection of a host that stays silent."""

from __future__ import annotations

import socket
import time

from canwire import BadValue
from canwire.slcan.wires import CHUNK


class TcpWire:
    """Listens at HOST:PORT; `:PORT` and `PORT` mean this machine only. Port 0 selects a free port.

    It accepts one host at a time, as a dongle has one cable; further connections are closed immediately. A host that
    has not sent a whole command excludes no other host: the next connection replaces it, and `greeting_s` seconds
    after it connected its connection is closed.
    """

    def __init__(self, address: str, greeting_s: float = 30) -> None:
        host, _, port = address.rpartition(":")
        if not port.isdecimal() or int(port) > 0xFFFF:
            raise BadValue(f"{address!r}: HOST:PORT, like 127.0.0.1:5000")
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._listener = socket.socket(family, socket.SOCK_STREAM)
        self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._listener.bind((host.strip("[]") or "127.0.0.1", int(port)))
            self._listener.listen()
        except OSError:
            self._listener.close()
            raise
        self._listener.setblocking(False)
        self._host: socket.socket | None = None
        self._next: socket.socket | None = None  # replaces a silent host
        self._greeting_s = greeting_s
        self._silent_until: float | None = None  # monotonic; None once the host has sent a command
        bound = self._listener.getsockname()
        self.port = int(bound[1])
        self.name = f"socket://{bound[0]}:{self.port}"
        self.refused = 0

    @property
    def connected(self) -> bool:
        return self._host is not None

    def descriptors(self) -> tuple[int, ...]:
        own = self._listener.fileno()
        return (own,) if self._host is None else (own, self._host.fileno())

    def writing(self) -> int:
        return -1 if self._host is None else self._host.fileno()

    @property
    def look_s(self) -> float | None:
        if self._next is not None:
            return 0.0
        return None if self._silent_until is None else max(0.0, self._silent_until - time.monotonic())

    def look(self) -> None:
        if self._next is not None:
            self._host, self._next = self._next, None
            self._silent_until = time.monotonic() + self._greeting_s
        elif self._silent_until is not None and time.monotonic() >= self._silent_until:
            self._hang_up()

    def read(self) -> bytes:
        self._accept()
        if self._host is None:
            return b""
        try:
            data = self._host.recv(CHUNK)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._hang_up()
        elif b"\r" in data:
            self._silent_until = None
        return data

    def write(self, data: bytes | bytearray | memoryview) -> int:
        if self._host is None:
            return 0
        try:
            return self._host.send(data)
        except BlockingIOError:
            return 0
        except OSError:
            self._hang_up()
            return 0

    def close(self) -> None:
        self._hang_up()
        if self._next is not None:
            self._next.close()
        self._listener.close()

    def _accept(self) -> None:
        try:
            host, _ = self._listener.accept()
        except OSError:  # nobody, or gone again
            return
        if self._next is not None or (self._host is not None and self._silent_until is None):
            self.refused += 1
            host.close()
            return
        host.setblocking(False)
        host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        host.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        self._hang_up()
        self._next = host

    def _hang_up(self) -> None:
        self._silent_until = None
        if self._host is not None:
            self._host.close()
            self._host = None
