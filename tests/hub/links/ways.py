"""Raw ends of the stream between programs and a hub, as this system has it: what tests that speak bytes need."""

from __future__ import annotations

import os
import secrets
import socket
import struct
from pathlib import Path

import pytest

from canwire.hub.protocol import messages as m
from canwire.platform import PORTABLE

AGES = 60.0  # seconds; only a broken build waits that long

unix_only = pytest.mark.skipif(PORTABLE, reason="about Unix sockets and their descriptors")
portable_only = pytest.mark.skipif(not PORTABLE, reason="CANWIRE_PLATFORM=portable only")

if PORTABLE:
    from canwire.hub.links.loopback import asides, sockets
    from canwire.hub.links.loopback.place import Place, read_place
    from canwire.platform.portable.pairs import LOOPBACK, loopback_listener

    def bare() -> socket.socket:
        """A socket that a caller has before it calls."""
        return socket.socket(socket.AF_INET)

    def address_at(path: str | Path) -> tuple[str, int]:
        """What a caller connects to."""
        place = read_place(str(path))
        assert place is not None
        return LOOPBACK, place.port

    def introduce(caller: socket.socket, path: str | Path) -> None:
        """What a client does before it speaks the protocol."""
        place, nonce = read_place(str(path)), secrets.token_bytes(sockets.NONCE_SIZE)
        assert place is not None
        caller.sendall(place.token + sockets.REST.pack(nonce, os.getpid()))
        assert exactly(caller, sockets.PROOF_SIZE) == place.proof(nonce)

    def leave_dead(path: str | Path) -> None:
        """What is there after a hub was killed."""
        with loopback_listener(1) as dead:
            Place(dead.getsockname()[1], secrets.token_bytes(32)).write(str(path))

    def listen(path: str | Path) -> socket.socket:
        """As a hub would."""
        return sockets.listen_at(str(path))[0]

    def accept(listener: socket.socket, path: str | Path) -> socket.socket:
        """One caller, up to where it speaks the protocol."""
        listener.setblocking(True)
        caller, _ = listener.accept()
        place = read_place(str(path))
        assert place is not None
        assert exactly(caller, len(place.token)) == place.token
        nonce, _ = sockets.REST.unpack(exactly(caller, sockets.REST.size))
        caller.sendall(place.proof(nonce))
        return caller

else:
    from canwire.hub.links.unix_socket import sockets

    def bare() -> socket.socket:
        return socket.socket(socket.AF_UNIX)

    def address_at(path: str | Path) -> str:
        return str(path)

    def introduce(caller: socket.socket, path: str | Path) -> None:
        """The system tells the hub who calls."""

    def leave_dead(path: str | Path) -> None:
        with socket.socket(socket.AF_UNIX) as dead:
            dead.bind(str(path))

    def listen(path: str | Path) -> socket.socket:
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(str(path))
        listener.listen()
        return listener

    def accept(listener: socket.socket, path: str | Path) -> socket.socket:
        return listener.accept()[0]


def exactly(caller: socket.socket, count: int) -> bytes:
    """So many bytes, or fewer at the end."""
    data = b""
    while len(data) < count and (some := caller.recv(count - len(data))):
        data += some
    return data


class Stream:
    """A client's end: bytes out; replies' payloads and what came beside them in."""

    def __init__(self, path: str | Path) -> None:
        self.socket = bare()
        self.socket.settimeout(AGES)
        self.socket.connect(address_at(path))
        introduce(self.socket, path)
        self.descriptors: list[object] = []
        self.signalled: list[int] = []
        self._inbox = m.Inbox(m.LARGEST_REPLY)

    def ring(self) -> None:
        """Tell the hub of frames in this client's queues."""
        if PORTABLE:
            self.socket.sendall(asides.numbered(asides.SIGNALLED, asides.DOORBELL))
        else:
            [doorbell, *_] = self.descriptors
            assert isinstance(doorbell, int)
            os.write(doorbell, struct.pack("=Q", 1))

    def receive(self) -> list[bytes]:
        """Payloads of some messages; raises EOFError at the end."""
        try:
            if PORTABLE:
                data = self.socket.recv(1 << 16)
            else:
                data, descriptors, _, _ = socket.recv_fds(self.socket, 1 << 16, 64)
                self.descriptors += descriptors
        except ConnectionResetError:
            data = b""
        if not data:
            raise EOFError
        return [payload for payload in self._inbox.feed(data) if not self._aside(payload)]

    def close(self) -> None:
        self.socket.close()
        for descriptor in self.descriptors:
            if isinstance(descriptor, int):
                os.close(descriptor)
        self.descriptors = []

    def _aside(self, payload: bytes) -> bool:
        if not PORTABLE or payload[:1] not in (asides.SIGNALLED, asides.PASSED):
            return False
        if payload[:1] == asides.SIGNALLED:
            self.signalled.append(asides.number_in(payload))
            return True
        items = asides.items_in(payload)
        self.descriptors += [(len(self.descriptors) + place, *item) for place, item in enumerate(items)]
        if any(kind == asides.MEMORY for kind, _, _ in items):
            self.socket.sendall(asides.framed(asides.FETCHED))
        return True
