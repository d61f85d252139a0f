"""The broadcast manager's messages as bytes.

Source: linux/can/bcm.h. `struct bcm_timeval` has two longs: 64 bits here.
"""

from __future__ import annotations

import errno
import struct
from dataclasses import dataclass

from canwire.socketcan.constants import CAN_MTU, CANFD_MTU
from canwire.socketcan.ports import refuse

TX_SETUP, TX_DELETE, TX_READ, TX_SEND, RX_SETUP, RX_DELETE, RX_READ = range(1, 8)
TX_STATUS, TX_EXPIRED, RX_STATUS, RX_TIMEOUT, RX_CHANGED = range(8, 13)

SETTIMER, STARTTIMER, TX_COUNTEVT, TX_ANNOUNCE, TX_CP_CAN_ID = 0x1, 0x2, 0x4, 0x8, 0x10
RX_FILTER_ID, RX_CHECK_DLC, RX_NO_AUTOTIMER, RX_ANNOUNCE_RESUME = 0x20, 0x40, 0x80, 0x100
TX_RESET_MULTI_IDX, RX_RTR_FRAME, CAN_FD_FRAME = 0x200, 0x400, 0x800

MOST_FRAMES = 256
_HEAD = struct.Struct("<III4xqqqqII")
HEAD_SIZE = _HEAD.size
_MICRO = 1_000_000
_LONGEST_S = 400 * 24 * 3600  # the kernel's own limit
_ID, LENGTH_AT, DATA_AT = struct.Struct("<I"), 4, 8


@dataclass(frozen=True)
class Message:
    """A head and its frames, each a struct can_frame, or canfd_frame with CAN_FD_FRAME; intervals in seconds."""

    opcode: int
    flags: int
    count: int
    interval1_s: float
    interval2_s: float
    can_id: int
    frames: tuple[bytes, ...] = ()

    @property
    def fd(self) -> bool:
        return bool(self.flags & CAN_FD_FRAME)

    @property
    def size(self) -> int:
        """The size of the whole message in bytes."""
        return HEAD_SIZE + sum(map(len, self.frames))

    @classmethod
    def parse(cls, data: bytes) -> Message:
        """The message in a program's bytes; raises OSError (EINVAL) for one that the kernel refuses."""
        if len(data) < HEAD_SIZE:
            raise refuse(errno.EINVAL)
        opcode, flags, count, s1, us1, s2, us2, can_id, nframes = _HEAD.unpack_from(data)
        size = CANFD_MTU if flags & CAN_FD_FRAME else CAN_MTU
        body = data[HEAD_SIZE:]
        if len(body) % size or (opcode == TX_SEND and len(body) != size):
            raise refuse(errno.EINVAL)
        taken = nframes if opcode in (TX_SETUP, RX_SETUP, TX_SEND) else 0
        if taken * size > len(body):
            raise refuse(errno.EINVAL if taken > MOST_FRAMES + 1 else errno.EFAULT)
        # programs write a whole struct with room for many frames, of which the first nframes count
        frames = tuple(body[at : at + size] for at in range(0, taken * size, size))
        if opcode != RX_SETUP and any(frame[LENGTH_AT] > size - DATA_AT for frame in frames):
            raise refuse(errno.EINVAL)
        return cls(opcode, flags, count, _seconds(s1, us1), _seconds(s2, us2), can_id, frames)

    def pack(self) -> bytes:
        first, second = _parts(self.interval1_s), _parts(self.interval2_s)
        head = _HEAD.pack(self.opcode, self.flags, self.count, *first, *second, self.can_id, len(self.frames))
        return head + b"".join(self.frames)


def id_of(frame: bytes) -> int:
    """The identifier word, flags included."""
    return int(_ID.unpack_from(frame)[0])


def with_id(frame: bytes, can_id: int) -> bytes:
    return _ID.pack(can_id) + frame[_ID.size :]


def _seconds(whole: int, micro: int) -> float:
    if whole < 0 or micro < 0 or micro >= _MICRO or whole > _LONGEST_S:
        raise refuse(errno.EINVAL)
    return whole + micro / _MICRO


def _parts(seconds: float) -> tuple[int, int]:
    return divmod(round(seconds * _MICRO), _MICRO)
