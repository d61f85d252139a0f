"""TPACKET_V2: a ring of frames of one size, each handed over by itself."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from canwire.socketcan.constants import CANFD_MTU
from canwire.socketcan.packets.ring import (
    LOSING,
    OF_KERNEL,
    OF_PROGRAM,
    RingMemory,
    RingRequest,
)
from canwire.socketcan.wire import numpy_module

if TYPE_CHECKING:
    import numpy

    Array = numpy.ndarray

_SOFTWARE_STAMP = 1 << 29  # TP_STATUS_TS_SOFTWARE
_SECOND = 1_000_000_000


class FrameRing:
    """A Ring (packets/ring.py) of frames."""

    def __init__(self, request: RingRequest) -> None:
        self.memory = RingMemory(request.size)
        self._request = request
        self._room = min(CANFD_MTU, request.frame_size - request.data_at)  # for a frame's own bytes
        self._next = 0
        self.packets = self.drops = self.freezes = 0
        self.last_at = -1

    @cached_property
    def _frames(self) -> Array:
        """All frames, by block."""
        numpy, request = numpy_module(), self._request
        room = self._room
        words = ["status", "len", "snaplen"]
        fields = {name: ("<u4", 4 * at) for at, name in enumerate(words)}
        fields |= {"mac": ("<u2", 12), "net": ("<u2", 14), "seconds": ("<u4", 16), "ns": ("<u4", 20)}
        fields |= {"address": ("V20", request.address_at)}
        if room > 0:
            fields["data"] = (f"V{room}", request.data_at)
        kind = numpy.dtype(
            {
                "names": list(fields),
                "formats": [form for form, _ in fields.values()],
                "offsets": [at for _, at in fields.values()],
                "itemsize": request.frame_size,
            }
        )
        found: Array = numpy.ndarray(
            (request.blocks, request.per_block),
            kind,
            self.memory.bytes,
            strides=(request.block_size, request.frame_size),
        )
        return found

    def put(self, rows: Array, addresses: Array) -> bool:
        numpy, request = numpy_module(), self._request
        self.packets += len(rows)
        places = (self._next + numpy.arange(min(len(rows), request.frames))) % request.frames
        at = places // request.per_block, places % request.per_block
        taken = self._frames["status"][at] != OF_KERNEL
        count = int(taken.argmax()) if taken.any() else len(places)
        lost = len(rows) - count
        self.drops += lost
        if not count:
            return False
        at = at[0][:count], at[1][:count]
        self._write(at, rows[:count], addresses[:count])
        self._frames["status"][at] = OF_PROGRAM | _SOFTWARE_STAMP | (LOSING if self.drops else 0)
        last = int(places[count - 1])
        self._next = (last + 1) % request.frames
        block, frame = divmod(last, request.per_block)
        self.last_at = block * request.block_size + frame * request.frame_size
        return True

    def _write(self, at: tuple[Array, Array], rows: Array, addresses: Array) -> None:
        frames, request = self._frames, self._request
        frames["len"][at] = rows["length"]
        frames["mac"][at] = frames["net"][at] = request.data_at
        frames["seconds"][at] = rows["stamp_ns"] // _SECOND
        frames["ns"][at] = rows["stamp_ns"] % _SECOND
        frames["address"][at] = addresses.view("V20")
        room = self._room
        frames["snaplen"][at] = numpy_module().minimum(rows["length"], room)
        if room:
            data = numpy_module().ascontiguousarray(rows).view("u1").reshape(len(rows), -1)
            start = data.shape[1] - CANFD_MTU
            frames["data"][at] = (
                numpy_module().ascontiguousarray(data[:, start : start + room]).view(f"V{room}").reshape(-1)
            )

    def close(self) -> None:
        self.memory.close()
