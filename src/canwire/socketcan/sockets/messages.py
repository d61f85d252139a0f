"""What CAN_BCM and CAN_ISOTP have in common: the program's messages come as requests, single frames go to a line."""

from __future__ import annotations

import errno
import struct
from collections import deque
from typing import TYPE_CHECKING, Any

from canwire.socketcan.constants import CANFD_MTU
from canwire.socketcan.interfaces import FULL
from canwire.socketcan.outlets import MessageOutlet
from canwire.socketcan.ports import Ports
from canwire.socketcan.sockets.base import CanSocket, message_of
from canwire.socketcan.wire import numpy_module, sent_dtype, sound

if TYPE_CHECKING:
    import socket
    from collections.abc import Callable

    from canwire.socketcan.control import Asked
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.port import Port
    from canwire.socketcan.setting import Setting

_SENT = struct.Struct("<iI")
_MOST_WAITING = 4096


class MessageSocket(CanSocket):
    """`sent` takes what the program has written, and answers it."""

    def __init__(
        self,
        setting: Setting,
        ports: Ports,
        slot: int,
        end: socket.socket,
        closed: Callable[[CanSocket], object],
    ) -> None:
        self.outlet: MessageOutlet = MessageOutlet(end)
        self._queued: dict[Port, deque[bytes]] = {}
        super().__init__(setting, ports, slot, end, closed)

    def sent(self, data: bytes, index: int, waits: bool, asked: Asked) -> None:
        """Answer it, now or later; raises OSError for what fails."""
        raise NotImplementedError

    def tell(self, payload: bytes, stamp_ns: int, index: int, error: int = 0) -> None:
        """Put a message before the program."""
        if self.over:
            return
        try:
            self.outlet.put(message_of(payload, stamp_ns, index, self.outlet.drops, error))
        except ConnectionError:
            self.close()
            return
        self.setting.stir()
        self.rewatch()

    def send_frame(self, port: Port, frame: bytes) -> None:
        """A struct can_frame or canfd_frame; waits here while the line has no room."""
        waiting = self._queued.setdefault(port, deque())
        if len(waiting) < _MOST_WAITING:
            waiting.append(frame)
        else:
            port.drop(1, FULL)
        if len(waiting) == 1:
            self._drain(port)

    def _drain(self, port: Port) -> None:
        waiting = self._queued.get(port)
        if waiting is None:  # dropped with its interface
            return
        while waiting and port.room():
            row = row_of(waiting.popleft(), port.interface.index)
            if sound(row).all():
                port.send(self.slot, row)
        if port.lost:
            port.drop(len(waiting))
            del self._queued[port]
        elif waiting:
            port.when_room(lambda: self._drain(port))

    def wants_writable(self) -> bool:
        return self.outlet.waiting > 0

    def written(self) -> None:
        self.outlet.flush()
        self.setting.stir()

    def readable(self) -> None:
        """Programs send by requests: whatever arrives here is the end."""
        try:
            if self.end.recv(1 << 16):
                return
        except BlockingIOError:
            return
        self.close()

    def congested(self) -> bool:
        return False

    def interface_lost(self, interface: Interface, error: int) -> None:
        self.setting.table.set_error(self.slot, error)
        if error == errno.ENODEV:
            self.setting.table.unbind(self.slot)
        self.tell(b"", 0, interface.index, error)


def row_of(frame: bytes, index: int) -> Any:
    """One row of `sent_dtype`."""
    packed = _SENT.pack(index, len(frame)) + frame.ljust(CANFD_MTU, b"\0")
    return numpy_module().frombuffer(bytearray(packed), sent_dtype())
