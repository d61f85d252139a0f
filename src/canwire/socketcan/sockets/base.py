"""What the server's side of every CAN socket has: an end of a pair, a slot, and what waits for the program."""

from __future__ import annotations

import errno
import struct
from typing import TYPE_CHECKING, Protocol

from canwire.socketcan.constants import AF_CAN, SOCKADDR_CAN_SHORTEST
from canwire.socketcan.loop import HUNG_UP, READABLE, WRITABLE
from canwire.socketcan.ports import Ports, refuse

if TYPE_CHECKING:
    import socket
    from collections.abc import Callable

    from canwire.socketcan.setting import Setting

_ADDRESS = struct.Struct("<Hxxi")
_RECEIVED = struct.Struct("<QIiHHI")  # shim/shim.h, struct received


class Outlet(Protocol):
    """outlets.py's: what waits for the program."""

    drops: int

    @property
    def waiting(self) -> int: ...

    def flush(self) -> None: ...


class CanSocket:
    """`readable` takes what the program has sent; `end` is watched for that until `pause`."""

    def __init__(
        self,
        setting: Setting,
        ports: Ports,
        slot: int,
        end: socket.socket,
        closed: Callable[[CanSocket], object],
    ) -> None:
        self.setting = setting
        self.ports = ports
        self.slot = slot
        self.end = end
        self.over = False
        self._closed = closed
        self._paused = False
        self._watched = 0
        self.rewatch()

    outlet: Outlet

    # what the program asks; each raises OSError with what its call fails with

    def bind(self, address: bytes) -> None:
        raise refuse(errno.EOPNOTSUPP)

    def connect(self, address: bytes) -> None:
        raise refuse(errno.EOPNOTSUPP)

    def set_option(self, level: int, name: int, value: bytes) -> None:
        raise refuse(errno.ENOPROTOOPT)

    def get_option(self, level: int, name: int) -> bytes:
        raise refuse(errno.ENOPROTOOPT)

    # what happens on the descriptor

    def readable(self) -> None:
        """Take in what the program has sent; `close` once it has closed its last descriptor."""
        raise NotImplementedError

    def relieved(self) -> None:
        """The program has read some of what waited for it."""

    def ended(self) -> None:
        """Nobody has a descriptor any more: let go of everything, and then `let_go`, now or later."""
        raise NotImplementedError

    def pause(self) -> None:
        """There is no room for what the program sends: let it wait in the socket."""
        self._paused = True
        self.rewatch()

    def resume(self) -> None:
        self._paused = False
        if not self.over:
            self.rewatch()

    def rewatch(self) -> None:
        """Watch the end for what is of interest now."""
        waiting = hasattr(self, "outlet") and self.outlet.waiting
        wanted = (0 if self._paused else READABLE) | (WRITABLE if waiting else 0)
        if wanted == self._watched:
            return
        self._watched = wanted
        if wanted:
            self.setting.loop.watch(self.end.fileno(), wanted, self._happened)
        else:
            self.setting.loop.forget(self.end.fileno())  # hang-ups would be told again and again

    def close(self) -> None:
        """A second time does nothing."""
        if self.over:
            return
        self.over = True
        self.setting.loop.forget(self.end.fileno())
        self.end.close()
        self.ended()

    def let_go(self) -> None:
        """Nothing is left of it: its slot is free."""
        self._closed(self)

    def _happened(self, events: int) -> None:
        try:
            if events & WRITABLE and not self.over:
                self.outlet.flush()
                self.relieved()
            if events & (READABLE | HUNG_UP) and not self.over and not self._paused:
                self.readable()
        except (BrokenPipeError, ConnectionResetError, ConnectionRefusedError):
            self._hung_up()
        if not self.over:
            self.rewatch()

    def _hung_up(self) -> None:
        """Nobody reads any more; what was sent before counts."""
        try:
            while not self.over and not self._paused:
                self.readable()
        except (ConnectionResetError, BrokenPipeError):
            self.close()


def index_of(address: bytes) -> int:
    """The interface in a `struct sockaddr_can`, 0: all. Raises OSError."""
    if len(address) < SOCKADDR_CAN_SHORTEST:
        raise refuse(errno.EINVAL)
    family, index = _ADDRESS.unpack_from(address)
    if family != AF_CAN:
        raise refuse(errno.EINVAL)
    return int(index)


def message_of(payload: bytes, stamp_ns: int, interface: int, drops: int, error: int = 0) -> bytes:
    """A message to the program, behind its header."""
    return _RECEIVED.pack(stamp_ns, drops, interface, 0, error, len(payload)) + payload
