"""The memory of a ring that a program requests by PACKET_RX_RING, and the checks of the request.

Source: Linux' Documentation/networking/packet_mmap.rst, linux/if_packet.h; the checks are those of packet_set_ring.
"""

from __future__ import annotations

import errno
import mmap
import os
import struct
from typing import TYPE_CHECKING, NamedTuple, Protocol

from canwire.socketcan.ports import refuse

if TYPE_CHECKING:
    import numpy

    Array = numpy.ndarray

V2, V3 = 1, 2
HEADER_SIZES = {V2: 32, V3: 48}  # struct tpacket2_hdr, tpacket3_hdr
ADDRESS_SIZE = 20  # struct sockaddr_ll, which follows
OF_KERNEL, OF_PROGRAM, LOSING, TIMED_OUT = 0, 1, 1 << 2, 1 << 5  # TP_STATUS_
_ALIGNMENT = 16
_LINK_HEADER = 16  # the least room for one; CAN has none
_MOST = 1 << 28  # bytes
_REQUEST, _MORE = struct.Struct("<4I"), struct.Struct("<3I")


class RingRequest(NamedTuple):
    """struct tpacket_req or tpacket_req3; `reserve` is the value of PACKET_RESERVE."""

    version: int
    reserve: int
    block_size: int
    blocks: int
    frame_size: int
    frames: int
    retire_ms: int = 0
    private: int = 0

    @classmethod
    def parse(cls, value: bytes, version: int, reserve: int) -> RingRequest:
        """The request in this value; raises OSError as setsockopt does."""
        needed = _REQUEST.size + (_MORE.size if version == V3 else 0)
        if version not in HEADER_SIZES or len(value) < needed:
            raise refuse(errno.EINVAL)
        more = _MORE.unpack_from(value, _REQUEST.size)[:2] if version == V3 else ()
        found = cls(version, reserve, *_REQUEST.unpack_from(value), *more)
        if found.blocks:
            found._check()
        elif found.frames:
            raise refuse(errno.EINVAL)
        return found

    def _check(self) -> None:
        sound = self.block_size > 0 and self.block_size % mmap.PAGESIZE == 0
        sound = sound and self.frame_size >= self.data_at and self.frame_size % _ALIGNMENT == 0
        sound = sound and self.per_block > 0 and self.per_block * self.blocks == self.frames
        if self.version == V3:
            sound = sound and self.private % 8 == 0 and self.private + self.data_at + 128 < self.block_size
        if not sound:
            raise refuse(errno.EINVAL)
        if self.size > _MOST:
            raise refuse(errno.ENOMEM)

    @property
    def per_block(self) -> int:
        return self.block_size // self.frame_size if self.frame_size else 0

    @property
    def size(self) -> int:
        return self.block_size * self.blocks

    @property
    def address_at(self) -> int:
        """The offset of the struct sockaddr_ll of a frame."""
        return aligned(HEADER_SIZES[self.version])

    @property
    def data_at(self) -> int:
        """The offset of the data of a frame: tp_mac."""
        return aligned(self.address_at + ADDRESS_SIZE + _LINK_HEADER) + self.reserve


def aligned(size: int) -> int:
    return size + -size % _ALIGNMENT


class RingMemory:
    """Memory shared with the program, which gets `descriptor`. Raises OSError (ENOMEM)."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.descriptor = os.memfd_create("canwire-packets", os.MFD_CLOEXEC)
        try:
            os.ftruncate(self.descriptor, size)
            self.bytes = mmap.mmap(self.descriptor, size)
        except OSError:
            os.close(self.descriptor)
            raise refuse(errno.ENOMEM) from None

    def close(self) -> None:
        """Unmap the memory here; the program keeps its mapping."""
        os.close(self.descriptor)


class Ring(Protocol):
    """A ring in one of the layouts: it accepts rows of `received_dtype`, with a struct sockaddr_ll for each."""

    memory: RingMemory
    packets: int
    drops: int
    freezes: int
    last_at: int  # where the state of what came last is, bytes; -1: nothing has come

    def put(self, rows: Array, addresses: Array) -> bool:
        """Add rows; returns whether the program has something new to read. Rows that do not fit are counted."""

    def close(self) -> None: ...
