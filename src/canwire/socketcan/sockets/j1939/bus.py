"""The J1939 networks of the interfaces in use: each is shared by all J1939 sockets that are bound there."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from canwire.socketcan.constants import CAN_EFF_FLAG, CAN_EFF_MASK, CAN_MTU, CAN_RTR_FLAG
from canwire.socketcan.echoes import NOBODY
from canwire.socketcan.j1939.endpoint import Endpoint
from canwire.socketcan.j1939.message import Message, message_of
from canwire.socketcan.j1939.network import Network
from canwire.socketcan.sockets.frame_queue import FrameQueue
from canwire.socketcan.wire import LOCAL, numpy_module

if TYPE_CHECKING:
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.port import Port
    from canwire.socketcan.setting import Setting
    from canwire.socketcan.wire import Batch

_FRAME = struct.Struct("<IBxxx8s")


class Member(Protocol):
    """A socket on this bus."""

    slot: int
    endpoint: Endpoint

    def confirm(self, message: Message) -> None:
        """A frame of this socket was on the bus."""

    def bus_lost(self, interface: Interface, error: int) -> None: ...


class J1939Bus:
    """The J1939 network of one port, from which it receives while it has members."""

    def __init__(self, setting: Setting, port: Port, emptied: Callable[[], object]) -> None:
        self.port = port
        self.network = Network(setting.loop, self._put)
        self._emptied = emptied
        self._members: dict[int, Member] = {}
        self._frames = FrameQueue()
        port.listeners.append(self)

    def join(self, member: Member) -> None:
        self._members[member.slot] = member
        self.network.endpoints.append(member.endpoint)

    def leave(self, member: Member) -> None:
        """Remove a member; a second call has no effect."""
        if self._members.pop(member.slot, None) is None:
            return
        self.network.endpoints.remove(member.endpoint)
        if not self._members:
            self.port.leave(self)
            self._emptied()

    # what the port tells

    def take(self, batch: Batch) -> None:
        rows = batch.rows
        wanted = rows["can_id"] & (CAN_EFF_FLAG | CAN_RTR_FLAG) == CAN_EFF_FLAG
        wanted &= rows["length"] == CAN_MTU
        if batch.errors is not None:
            wanted &= ~batch.errors
        for at in numpy_module().nonzero(wanted)[0]:
            row, member = rows[at], self._members.get(int(batch.owners[at]))
            data = row["data"][: int(row["len"])].tobytes()
            message = message_of(int(row["can_id"]) & CAN_EFF_MASK, data)
            if member is not None:
                member.confirm(message)
            sender = None if member is None else member.endpoint
            self.network.take(message, int(row["stamp_ns"]), sender, bool(row["flags"] & LOCAL))

    def congested(self) -> bool:
        return False

    def interface_lost(self, interface: Interface, error: int) -> None:
        self.network.stop(error)
        for member in list(self._members.values()):
            member.bus_lost(interface, error)

    def _put(self, message: Message, endpoint: Endpoint | None) -> None:
        slots = (member.slot for member in self._members.values() if member.endpoint is endpoint)
        frame = _FRAME.pack(message.identifier | CAN_EFF_FLAG, len(message.data), message.data)
        self._frames.send(self.port, next(slots, NOBODY), frame)


class J1939Buses:
    """The J1939 networks of one server."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._by_port: dict[Port, J1939Bus] = {}

    def of(self, port: Port) -> J1939Bus:
        """The network of this port, made for its first socket."""
        if port not in self._by_port:
            self._by_port[port] = J1939Bus(self._setting, port, lambda: self._by_port.pop(port))
        return self._by_port[port]
