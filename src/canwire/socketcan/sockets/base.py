"""What the server's side of every CAN socket has: an end of a pair, a slot, and what waits for the program."""

from __future__ import annotations

import errno
import select
import struct
from typing import TYPE_CHECKING, NamedTuple

from canwire.socketcan.constants import AF_CAN, SOCKADDR_CAN_SHORTEST
from canwire.socketcan.loop import HUNG_UP, READABLE, WRITABLE
from canwire.socketcan.ports import Ports, refuse

if TYPE_CHECKING:
    import socket
    from collections.abc import Callable

    from canwire.socketcan.netlink.proc_files import Wanted
    from canwire.socketcan.rings import RingPair, Row
    from canwire.socketcan.setting import Setting
    from canwire.socketcan.sockets.error_queue import Queued

LARGEST_MESSAGE = 1 << 17  # bytes that a program sends past the library
_ADDRESS = struct.Struct("<Hxxi")
_RECEIVED = struct.Struct("<QIiHHI")  # shim/shim.h, struct received


class Opened(NamedTuple):
    """What a socket is made of: `end` is the server's end of its pair, `closed` is called when nothing is left."""

    setting: Setting
    ports: Ports
    slot: int
    end: socket.socket
    ring: RingPair
    closed: Callable[[CanSocket], object]


class CanSocket:
    """Its end of the pair is watched."""

    def __init__(self, opened: Opened) -> None:
        self.setting, self.ports, self.slot, self.end, self.ring, self._closed = opened
        self.over = False
        self.waiting: list[Callable[[], object]] = []
        self._watched = 0
        self.rewatch()

    def row_of_message(self, data: bytes, peeks: bool) -> Row:
        """rings.RingPair.row_of_message."""
        return self.ring.row_of_message(data, peeks)

    def told(self) -> None:
        """There is something for the program: who waits for it in a call that the server answers looks again."""
        waiting, self.waiting = self.waiting, []
        for look in waiting:
            self.setting.loop.soon(look)

    # what the program asks; each raises OSError with what its call fails with

    def bind(self, address: bytes) -> None:
        raise refuse(errno.EOPNOTSUPP)

    def connect(self, address: bytes) -> None:
        raise refuse(errno.EOPNOTSUPP)

    def set_option(self, level: int, name: int, value: bytes) -> None:
        raise refuse(errno.ENOPROTOOPT)

    def get_option(self, level: int, name: int) -> bytes:
        raise refuse(errno.ENOPROTOOPT)

    def stamps_changed(self) -> None:
        """SO_TIMESTAMPING asks for times of what is sent, or no longer."""

    def take_error(self) -> Queued:
        """The oldest entry of its error queue."""
        raise refuse(errno.EAGAIN)

    def receive_list(self) -> list[Wanted]:
        """What it hears, as /proc/net/can shows it."""
        return []

    def sent_to(self, data: bytes, address: bytes) -> None:
        """sendto of a program whose calls the server answers; no address: to where it is bound."""
        index = index_of(address) if address else self.setting.table.bound_to(self.slot)
        if index not in self.setting.interfaces.by_index:
            raise refuse(errno.ENXIO)
        self.send_to(data, index)

    def send_to(self, data: bytes, index: int) -> None:
        """The same, to an interface."""
        raise NotImplementedError

    # what happens on the descriptor

    def readable(self) -> None:
        """Something came from the program; `close` once it has closed its last descriptor."""
        raise NotImplementedError

    def ended(self) -> None:
        """Nobody has a descriptor any more: let go of everything, and then `let_go`, now or later."""
        raise NotImplementedError

    def rewatch(self) -> None:
        """Watch the end for what is of interest now."""
        wanted = (READABLE if self.wants_readable() else 0) | (WRITABLE if self.wants_writable() else 0)
        if wanted != self._watched:
            self._watched = wanted
            self.setting.loop.watch(self.end.fileno(), wanted, self._happened)

    def wants_readable(self) -> bool:
        """`readable` is to be called for more than the end."""
        return True

    def wants_writable(self) -> bool:
        """`written` is to be called when the end has room."""
        return False

    def written(self) -> None:
        """The end has room."""

    def arrived(self, most: int) -> tuple[list[bytes], bool]:
        """Messages that the program's end has sent, up to so many, and whether nobody has it any more."""
        found: list[bytes] = []
        while len(found) < most:
            try:
                message = self.end.recv(LARGEST_MESSAGE)
            except BlockingIOError:
                return found, False
            if not message and self._is_closed():
                return found, True
            found.append(message)  # of no bytes: an empty write
        return found, False

    def _is_closed(self) -> bool:
        poll = select.poll()
        poll.register(self.end.fileno(), 0)
        return any(events & select.POLLHUP for _, events in poll.poll(0))

    def close(self) -> None:
        """A second time does nothing."""
        if self.over:
            return
        self.over = True
        self.setting.loop.forget(self.end.fileno())
        self.end.close()
        self.ended()

    def boards_changed(self) -> None:
        """Interfaces may have come, or up."""

    @property
    def deserted(self) -> bool:
        """No program has it any more; what it sent may still be on its way."""
        return self.over

    def let_go(self) -> None:
        """Nothing is left of it: its slot is free."""
        self._closed(self)

    def _happened(self, events: int) -> None:
        try:
            if events & WRITABLE and not self.over:
                self.written()
            if events & (READABLE | HUNG_UP) and not self.over:
                self.readable()
        except ConnectionError:
            self.close()
        if not self.over:
            self.rewatch()


def index_of(address: bytes) -> int:
    """The interface in a `struct sockaddr_can`, 0: all. Raises OSError."""
    if len(address) < SOCKADDR_CAN_SHORTEST:
        raise refuse(errno.EINVAL)
    family, index = _ADDRESS.unpack_from(address)
    if family != AF_CAN:
        raise refuse(errno.EINVAL)
    return int(index)


def message_of(
    payload: bytes, stamp_ns: int, interface: int, drops: int, error: int = 0, flags: int = 0
) -> bytes:
    """A message to the program, after its header."""
    return _RECEIVED.pack(stamp_ns, drops, interface, flags, error, len(payload)) + payload
