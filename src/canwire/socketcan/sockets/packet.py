"""AF_PACKET, which tcpdump and Wireshark open: all frames unchanged, received ones and those passed to the line.

Source: packet(7), Linux' Documentation/networking/packet_mmap.rst, net/packet/af_packet.c.
"""

from __future__ import annotations

import errno
import socket
import struct
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire.socketcan.constants import CAN_MTU, CANFD_MTU
from canwire.socketcan.packets.blocks import BlockRing
from canwire.socketcan.packets.frames import FrameRing
from canwire.socketcan.packets.ring import V2, V3, Ring, RingRequest
from canwire.socketcan.ports import refuse
from canwire.socketcan.sockets.base import Opened
from canwire.socketcan.sockets.raw import RawSocket
from canwire.socketcan.wire import numpy_module, received_dtype

if TYPE_CHECKING:
    import numpy

    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.port import Port
    from canwire.socketcan.wire import Batch

    Array = numpy.ndarray

PACKET = 256  # the protocol of a slot: shim/shim.h
SOL_PACKET = 263
ADD_MEMBERSHIP, DROP_MEMBERSHIP, RX_RING, STATISTICS = 1, 2, 5, 6
AUXILIARY, VERSION, RESERVE, LOSS, TIMESTAMP, IGNORE_OUTGOING = 8, 10, 12, 14, 17, 23
_ALL, _CAN, _CAN_FD = 0x0003, 0x000C, 0x000D  # ETH_P_
_SIZES = {_CAN: CAN_MTU, _CAN_FD: CANFD_MTU}
_ADDRESS = struct.Struct("<HHi")  # struct sockaddr_ll: family, protocol (the network's order), index ...
_WHOLE_ADDRESS = struct.Struct("<H2siHBB8x")
_SHORTEST = 12
_HARDWARE, _BROADCAST, _OUTGOING = 280, 1, 4  # ARPHRD_CAN, PACKET_
OUTGOING = 4  # of a message: shim/shim.h
_INT = struct.Struct("<i")
_KEPT = (AUXILIARY, RESERVE, LOSS, TIMESTAMP, IGNORE_OUTGOING)
_WAKE = b"\0"


class PacketSocket(RawSocket):
    """An unbound socket receives from the interfaces that are in use when it is created."""

    def __init__(self, opened: Opened, protocol: int) -> None:
        super().__init__(opened)
        self._values = dict.fromkeys(_KEPT, 0) | {VERSION: 0}
        self._packet_ring: Ring | None = None
        self._counted = 0, 0  # packets and drops that are not the ring's
        self._set_protocol(protocol)
        if protocol:
            self._hear(self.ports.in_use())

    def _set_protocol(self, protocol: int) -> None:
        """`protocol` as it is in the program's memory."""
        self._about = socket.ntohs(protocol)
        self.setting.table.set_identifiers(self.slot, protocol, self._values[AUXILIARY])

    # what the program asks

    def bind(self, address: bytes) -> None:
        if len(address) < _SHORTEST:
            raise refuse(errno.EINVAL)
        family, protocol, index = _ADDRESS.unpack_from(address)
        if family != socket.AF_PACKET:
            raise refuse(errno.EINVAL)
        heard = self._ports_at(index)
        self._part()
        self._hears_later = index if not heard else 0
        if protocol:
            self._set_protocol(protocol)
        self._hears_all = index == 0
        self._hear(heard if self._about else [])
        self.setting.table.bind(self.slot, index)
        if index and heard:
            heard[0].tell_if_down(self)
        elif index:
            self.interface_lost(self.setting.interfaces.by_index[index], errno.ENETDOWN)

    def _part(self) -> None:
        for port in self._heard:
            port.leave(self)
            port.taps.discard(self)
        self._heard = []

    def _hear(self, ports: list[Port]) -> None:
        super()._hear(ports)
        for port in ports:
            port.taps.add(self)

    def set_option(self, level: int, name: int, value: bytes) -> None:
        if level != SOL_PACKET:
            raise refuse(errno.ENOPROTOOPT)
        if name == RX_RING:
            self._set_ring(RingRequest.parse(value, self._values[VERSION], self._values[RESERVE]))
        elif name in (ADD_MEMBERSHIP, DROP_MEMBERSHIP):
            return  # a line hears everything already
        elif name in self._values:
            self._keep(name, value)
        else:
            raise refuse(errno.ENOPROTOOPT)

    def _keep(self, name: int, value: bytes) -> None:
        if len(value) < _INT.size:
            raise refuse(errno.EINVAL)
        number = _INT.unpack_from(value)[0]
        if self._packet_ring is not None and name in (VERSION, RESERVE):
            raise refuse(errno.EBUSY)
        if name == VERSION and number not in (V2, V3):
            raise refuse(errno.EINVAL)
        if name == RESERVE and not 0 <= number < 1 << 16:
            raise refuse(errno.EINVAL)
        self._values[name] = number
        if name == AUXILIARY:
            receives, _ = self.setting.table.identifiers(self.slot)
            self.setting.table.set_identifiers(self.slot, receives, int(number != 0))

    def _set_ring(self, request: RingRequest) -> None:
        if self._packet_ring is not None:
            if request.blocks:
                raise refuse(errno.EBUSY)
            self._packet_ring.close()
            self._packet_ring = None
        if request.blocks:
            made = BlockRing(request, self.setting.loop, self._wake)
            self._packet_ring = made if request.version == V3 else FrameRing(request)
        self.setting.table.watch(self.slot, bool(request.blocks))
        self.setting.table.place_ring(self.slot, -1)

    def memory(self) -> tuple[int, int]:
        """The descriptor of the ring's memory, and its size; raises OSError."""
        if self._packet_ring is None:
            raise refuse(errno.EINVAL)
        return self._packet_ring.memory.descriptor, self._packet_ring.memory.size

    def get_option(self, level: int, name: int) -> bytes:
        if level != SOL_PACKET:
            raise refuse(errno.ENOPROTOOPT)
        if name == STATISTICS:
            return self._statistics()
        if name not in self._values:
            raise refuse(errno.ENOPROTOOPT)
        return _INT.pack(self._values[name])

    def _statistics(self) -> bytes:
        """struct tpacket_stats, tpacket_stats_v3: since they were read last."""
        ring = self._packet_ring
        if ring is None:
            packets, drops = self._counted
            now = self._outlet.drops
            self._counted = 0, now
            return struct.pack("<II", packets, now - drops)
        found = struct.pack("<II", ring.packets, ring.drops)
        if self._values[VERSION] == V3:
            found += struct.pack("<I", ring.freezes)
        ring.packets = ring.drops = ring.freezes = 0
        return found

    # from the line

    def take(self, batch: Batch) -> None:
        rows = batch.rows.copy()
        rows["flags"] = 0
        self._pass_on(rows)

    def going(self, interface: Interface, frames: Array) -> None:
        """Deliver these frames (`sent_dtype`), which were passed to the line, to a socket for all protocols."""
        if self._about != _ALL or self._values[IGNORE_OUTGOING]:
            return
        rows = numpy_module().zeros(len(frames), received_dtype())
        rows["stamp_ns"] = self.setting.hub.now_ns() + self.setting.epoch_ns
        rows["interface"], rows["length"], rows["flags"] = interface.index, frames["size"], OUTGOING
        for name in ("can_id", "len", "fd_flags", "reserved", "raw_dlc", "data"):
            rows[name] = frames[name]
        self._pass_on(rows)

    def _pass_on(self, rows: Array) -> None:
        if size := _SIZES.get(self._about):
            rows = rows[rows["length"] == size]
        if not len(rows):
            return
        if self._packet_ring is None:
            self._counted = self._counted[0] + len(rows), self._counted[1]
            self.put(rows)
        elif self._packet_ring.put(rows, _addresses(rows)):
            self._wake()

    def _wake(self) -> None:
        """Wake the program, as there is something in the ring."""
        assert self._packet_ring is not None
        self.setting.table.place_ring(self.slot, self._packet_ring.last_at)
        with suppress(BlockingIOError, ConnectionError):  # so many have not been taken: it is awake
            self.end.send(_WAKE)
        self.setting.stir()

    def interface_lost(self, interface: Interface, error: int) -> None:
        super().interface_lost(interface, errno.ENETDOWN)
        if error == errno.ENODEV:
            self._heard = [port for port in self._heard if port.interface is not interface]

    def ended(self) -> None:
        self._part()
        if self._packet_ring is not None:
            self._packet_ring.close()
        super().ended()


def _addresses(rows: Array) -> Array:
    """A struct sockaddr_ll for each."""
    kind = numpy_module().dtype(
        [
            ("family", "<u2"),
            ("protocol", ">u2"),
            ("index", "<i4"),
            ("hardware", "<u2"),
            ("type", "u1"),
            ("size", "u1"),
            ("address", "V8"),
        ]
    )
    found: Array = numpy_module().zeros(len(rows), kind)
    found["family"], found["hardware"] = socket.AF_PACKET, _HARDWARE
    found["index"] = rows["interface"]
    found["protocol"] = numpy_module().where(rows["length"] == CANFD_MTU, _CAN_FD, _CAN)
    found["type"] = numpy_module().where(rows["flags"] & OUTGOING != 0, _OUTGOING, _BROADCAST)
    return found
