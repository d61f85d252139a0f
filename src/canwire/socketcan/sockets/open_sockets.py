"""All CAN sockets of one server's programs: created here, found by slot or inode, removed when unused."""

from __future__ import annotations

import errno
import os
import socket
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from canwire.socketcan.constants import (
    CAN_BCM,
    CAN_ISOTP,
    CAN_J1939,
    CAN_RAW,
    SOCK_DGRAM,
    SOCK_RAW,
    TYPE_OF_PROTOCOL,
)
from canwire.socketcan.ports import Ports, refuse
from canwire.socketcan.sockets.base import CanSocket, Opened
from canwire.socketcan.sockets.bcm import BcmSocket
from canwire.socketcan.sockets.isotp import IsoTpSocket
from canwire.socketcan.sockets.j1939.bus import J1939Buses
from canwire.socketcan.sockets.j1939.socket import J1939Socket
from canwire.socketcan.sockets.packet import PACKET, PacketSocket
from canwire.socketcan.sockets.raw import RawSocket

if TYPE_CHECKING:
    from canwire.socketcan.rings import Rings
    from canwire.socketcan.setting import Setting

_KINDS: dict[int, Callable[[Opened], CanSocket]] = {
    CAN_RAW: RawSocket,
    CAN_BCM: BcmSocket,
    CAN_ISOTP: IsoTpSocket,
}


class OpenSockets:
    """`closed` is called after a socket was removed, `say_once` shows one line to the user; `prefix` begins names."""

    def __init__(
        self,
        setting: Setting,
        ports: Ports,
        rings: Rings,
        prefix: str,
        closed: Callable[[], object],
        say_once: Callable[[str], object],
    ) -> None:
        self._setting = setting
        self._ports = ports
        self._rings = rings
        self._buses = J1939Buses(setting)
        self._prefix = prefix
        self._on_closed = closed
        self._say_once = say_once
        self._by_slot: dict[int, CanSocket] = {}
        self._by_inode: dict[int, CanSocket] = {}

    def __len__(self) -> int:
        return len(self._by_slot)

    def __iter__(self) -> Iterator[CanSocket]:
        return iter(list(self._by_slot.values()))

    def of_slot(self, slot: int) -> CanSocket | None:
        return self._by_slot.get(slot)

    def of_inode(self, inode: int) -> CanSocket | None:
        """The socket whose program's end has this inode."""
        return self._by_inode.get(inode)

    def make(self, type: int, protocol: int, program: str) -> socket.socket:
        """Make a socket and return the program's end; raises OSError, with which the call of `socket` fails."""
        if protocol >> 16 == PACKET:
            if type not in (SOCK_DGRAM, SOCK_RAW):
                raise refuse(errno.ESOCKTNOSUPPORT)
            return self._opened(type, protocol)
        if protocol not in TYPE_OF_PROTOCOL:
            self._say_once(f"{program} asked for CAN protocol {protocol}, which there is not here")
            raise refuse(errno.EPROTONOSUPPORT)
        if type != TYPE_OF_PROTOCOL[protocol]:
            raise refuse(errno.EPROTOTYPE)
        return self._opened(type, protocol)

    def _opened(self, type: int, protocol: int) -> socket.socket:
        packet = protocol >> 16 == PACKET
        slot = self._setting.table.take_slot(PACKET if packet else protocol, type)
        if slot is None:
            raise refuse(errno.ENFILE)
        own, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        own.setblocking(False)
        theirs.bind(f"\0{self._prefix}{slot:04x}")
        inode = os.fstat(theirs.fileno()).st_ino

        def closed(one: CanSocket) -> None:
            self._by_slot.pop(slot, None)
            if self._by_inode.get(inode) is one:
                del self._by_inode[inode]
            self._setting.table.free_slot(slot)
            self._on_closed()

        try:
            ring = self._rings.pair(slot, own.fileno())
            made = self._made(protocol, Opened(self._setting, self._ports, slot, own, ring, closed))
        except OSError as error:
            own.close()
            theirs.close()
            self._setting.table.free_slot(slot)
            if error.errno != errno.ENOSPC:
                raise
            self._say_once(f"no more CAN sockets: {error.filename} is full")
            raise refuse(errno.ENOBUFS) from None
        self._by_slot[slot] = self._by_inode[inode] = made
        return theirs

    def _made(self, protocol: int, opened: Opened) -> CanSocket:
        if protocol >> 16 == PACKET:
            return PacketSocket(opened, protocol & 0xFFFF)
        if protocol == CAN_J1939:
            return J1939Socket(opened, self._buses)
        return _KINDS[protocol](opened)
