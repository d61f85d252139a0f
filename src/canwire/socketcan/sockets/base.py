"""The base class of the server's side of all CAN sockets: an end of a pair, a slot, and data for the program."""

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
    """The parts of a socket: `end` is the server's end of its pair, `closed` is called after its end."""

    setting: Setting
    ports: Ports
    slot: int
    end: socket.socket
    ring: RingPair
    closed: Callable[[CanSocket], object]


class CanSocket:
    """The server's side of a CAN socket. It watches its end of the pair."""

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
        """Data for the program has arrived: a call that waits for it, and that the server answers, checks again."""
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
        """SO_TIMESTAMPING was changed: times of sent frames are requested, or no longer."""

    def take_error(self) -> Queued:
        """The oldest entry of its error queue."""
        raise refuse(errno.EAGAIN)

    def receive_list(self) -> list[Wanted]:
        """The receive list of this socket, as /proc/net/can shows it."""
        return []

    def sent_to(self, data: bytes, address: bytes) -> None:
        """sendto of a program whose calls the server answers; without an address, to the bound interface."""
        index = index_of(address) if address else self.setting.table.bound_to(self.slot)
        if index not in self.setting.interfaces.by_index:
            raise refuse(errno.ENXIO)
        self.send_to(data, index)

    def send_to(self, data: bytes, index: int) -> None:
        """The same, to an interface."""
        raise NotImplementedError

    # what happens on the descriptor

    def readable(self) -> None:
        """Read data from the program; call `close` if it has closed its last descriptor."""
        raise NotImplementedError

    def ended(self) -> None:
        """No program has a descriptor any more: release everything, and then call `let_go`, now or later."""
        raise NotImplementedError

    def rewatch(self) -> None:
        """Watch the end for the events that are needed now."""
        wanted = (READABLE if self.wants_readable() else 0) | (WRITABLE if self.wants_writable() else 0)
        if wanted != self._watched:
            self._watched = wanted
            self.setting.loop.watch(self.end.fileno(), wanted, self._happened)

    def wants_readable(self) -> bool:
        """True if `readable` is to be called for data, too, not only for the end."""
        return True

    def wants_writable(self) -> bool:
        """True if `written` is to be called when the end has room."""
        return False

    def written(self) -> None:
        """The end has room."""

    def arrived(self, most: int) -> tuple[list[bytes], bool]:
        """Up to `most` messages from the program's end, and whether that end is closed everywhere."""
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
        """Close the socket; a second call has no effect."""
        if self.over:
            return
        self.over = True
        self.setting.loop.forget(self.end.fileno())
        self.end.close()
        self.ended()

    def boards_changed(self) -> None:
        """Interfaces may have been added, or may be up now."""

    @property
    def deserted(self) -> bool:
        """No program has this socket any more; frames that it has sent may still wait."""
        return self.over

    def let_go(self) -> None:
        """End the socket for good: its slot is free."""
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
