"""The options of an ISO-TP socket.

Source: linux/can/isotp.h.
"""

from __future__ import annotations

import errno
import struct
from dataclasses import dataclass, replace

from canwire.socketcan.constants import CAN_MTU, CANFD_MTU
from canwire.socketcan.ports import refuse

OPTS, RECV_FC, TX_STMIN, RX_STMIN, LL_OPTS = range(1, 6)

LISTEN_MODE, EXTEND_ADDR, TX_PADDING, RX_PADDING = 0x1, 0x2, 0x4, 0x8
CHK_PAD_LEN, CHK_PAD_DATA, HALF_DUPLEX, FORCE_TXSTMIN = 0x10, 0x20, 0x40, 0x80
FORCE_RXSTMIN, RX_EXT_ADDR, WAIT_TX_DONE, SF_BROADCAST, CF_BROADCAST = 0x100, 0x200, 0x400, 0x800, 0x1000

USUAL_PAD = 0xCC
USUAL_FRAME_TIME_NS = 50_000
LARGEST_PDU = 66_000  # MAX_MSG_LENGTH of kernel 6.1
LENGTHS = (8, 12, 16, 20, 24, 32, 48, 64)  # that a link layer may have
_NO_FRAME_TIME = 0xFFFF_FFFF
_OPTIONS = struct.Struct("<IIBBBB")
_WORD = struct.Struct("<I")


@dataclass(frozen=True)
class Options:
    """Times in ns. `block_size` and `stmin` are the values in the flow control of this side."""

    flags: int = 0
    frame_time_ns: int = USUAL_FRAME_TIME_NS
    address: int = 0
    tx_pad: int = USUAL_PAD
    rx_pad: int = USUAL_PAD
    rx_address: int = 0
    block_size: int = 0
    stmin: int = 0
    most_waits: int = 0
    mtu: int = CAN_MTU
    length: int = 8
    frame_flags: int = 0
    tx_stmin_ns: int = 0
    rx_stmin_ns: int = 0

    @property
    def extended(self) -> int:
        """The number of address bytes before those of the protocol: 1 in extended and mixed addressing."""
        return int(bool(self.flags & EXTEND_ADDR))

    @property
    def address_heard(self) -> int:
        return self.rx_address if self.flags & RX_EXT_ADDR else self.address

    def changed(self, name: int, value: bytes) -> Options:
        """The options with this socket option set; raises OSError for an invalid or unknown one."""
        sizes = {OPTS: 12, RECV_FC: 3, TX_STMIN: 4, RX_STMIN: 4, LL_OPTS: 3}
        if name not in sizes:
            raise refuse(errno.ENOPROTOOPT)
        if len(value) != sizes[name]:
            raise refuse(errno.EINVAL)
        if name == OPTS:
            return self._with_options(*_OPTIONS.unpack(value))
        if name == RECV_FC:
            return replace(self, block_size=value[0], stmin=value[1], most_waits=value[2])
        if name == TX_STMIN:
            return replace(self, tx_stmin_ns=_WORD.unpack(value)[0])
        if name == RX_STMIN:
            return replace(self, rx_stmin_ns=_WORD.unpack(value)[0])
        mtu, length, flags = value
        if mtu not in (CAN_MTU, CANFD_MTU) or length not in LENGTHS or (mtu == CAN_MTU and length > 8):
            raise refuse(errno.EINVAL)
        return replace(self, mtu=mtu, length=length, frame_flags=flags)

    def value(self, name: int) -> bytes:
        """The value of a socket option, as the program reads it; raises OSError."""
        if name == OPTS:
            time = self.frame_time_ns or _NO_FRAME_TIME
            return _OPTIONS.pack(self.flags, time, self.address, self.tx_pad, self.rx_pad, self.rx_address)
        if name == RECV_FC:
            return bytes((self.block_size, self.stmin, self.most_waits))
        if name in (TX_STMIN, RX_STMIN):
            return _WORD.pack(self.tx_stmin_ns if name == TX_STMIN else self.rx_stmin_ns)
        if name == LL_OPTS:
            return bytes((self.mtu, self.length, self.frame_flags))
        raise refuse(errno.ENOPROTOOPT)

    def _with_options(
        self, flags: int, time_ns: int, address: int, tx_pad: int, rx_pad: int, rx_address: int
    ) -> Options:
        if time_ns == 0:
            time_ns = self.frame_time_ns
        return replace(
            self,
            flags=flags,
            frame_time_ns=0 if time_ns == _NO_FRAME_TIME else time_ns,
            address=address,
            tx_pad=tx_pad,
            rx_pad=rx_pad,
            rx_address=rx_address,
        )
