"""TPACKET_V3: a ring of blocks of many frames, each handed over when it is full or after a time."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from canwire.socketcan.packets.ring import (
    LOSING,
    OF_KERNEL,
    OF_PROGRAM,
    TIMED_OUT,
    V3,
    RingMemory,
    RingRequest,
    aligned,
)
from canwire.socketcan.wire import numpy_module

if TYPE_CHECKING:
    import numpy

    from canwire.socketcan.loop import Loop, Timer

    Array = numpy.ndarray

_HEADER = struct.Struct("<IIIIIIQIIII")  # struct tpacket_block_desc
_STATE_AT, _WORD = 8, struct.Struct("<I")
_RETIRE_MS = 8  # where a program leaves it to the kernel
_SECOND = 1_000_000_000


class BlockRing:
    """A Ring (packets/ring.py) of blocks. `handed` is called when a block was handed over because of its time."""

    def __init__(self, request: RingRequest, loop: Loop, handed: Callable[[], object]) -> None:
        self.memory = RingMemory(request.size)
        self._request = request
        self._loop = loop
        self._handed = handed
        self._retire_s = (request.retire_ms or _RETIRE_MS) / 1000
        self._timer: Timer | None = None
        self._block = 0
        self._sequence = 0
        self._start = _HEADER.size + request.private
        self._begin()
        self._frozen = False
        self.packets = self.drops = self.freezes = 0
        self.last_at = -1

    def _begin(self) -> None:
        self._used, self._count, self._last = self._start, 0, 0
        self._first_ns = self._last_ns = 0

    @property
    def _place(self) -> int:
        return self._block * self._request.block_size

    def _free(self) -> bool:
        """The current block is not the program's."""
        return bool(_WORD.unpack_from(self.memory.bytes, self._place + _STATE_AT)[0] == OF_KERNEL)

    def put(self, rows: Array, addresses: Array) -> bool:
        self.packets += len(rows)
        handed = False
        for one, theirs in _by_length(rows, addresses):
            handed |= self._put_alike(one, theirs)
        return handed

    def _put_alike(self, rows: Array, addresses: Array) -> bool:
        """Frames of one length."""
        size = aligned(self._request.data_at + int(rows["length"][0]))
        handed = False
        while len(rows):
            if not self._count and not self._free():
                self.freezes += not self._frozen
                self._frozen = True
                self.drops += len(rows)
                return handed
            self._frozen = False
            count = min(len(rows), (self._request.block_size - self._used) // size)
            if count:
                self._write(rows[:count], addresses[:count], size)
                rows, addresses = rows[count:], addresses[count:]
            else:
                self._hand_over(0)
                handed = True
        return handed

    def _write(self, rows: Array, addresses: Array, size: int) -> None:
        place = self._place + self._used
        packed = numpy_module().zeros(len(rows), _frame_dtype(self._request, size))
        packed["next"] = size
        packed["seconds"], packed["ns"] = rows["stamp_ns"] // _SECOND, rows["stamp_ns"] % _SECOND
        packed["snaplen"] = packed["len"] = rows["length"]
        packed["status"] = OF_PROGRAM | (LOSING if self.drops else 0)
        packed["mac"] = packed["net"] = self._request.data_at
        packed["address"] = addresses.view("V20")
        length = int(rows["length"][0])
        frames = numpy_module().ascontiguousarray(rows).view("u1").reshape(len(rows), -1)
        start = frames.shape[1] - 72
        packed["data"] = frames[:, start : start + length]
        self.memory.bytes[place : place + packed.nbytes] = packed.tobytes()
        if not self._count:
            self._first_ns = int(rows["stamp_ns"][0])
            self._timer = self._loop.call_in(self._retire_s, self._expire)
        self._last_ns = int(rows["stamp_ns"][-1])
        self._last = place + packed.nbytes - size
        self._count += len(rows)
        self._used += packed.nbytes

    def _expire(self) -> None:
        self._hand_over(TIMED_OUT)
        self._handed()

    def _hand_over(self, why: int) -> None:
        """The block is the program's from now on; its last frame has none after it."""
        if self._timer is not None:
            self._timer.cancel()
        memory, place = self.memory.bytes, self._place
        _WORD.pack_into(memory, self._last, 0)
        self._sequence += 1
        first, last = divmod(self._first_ns, _SECOND), divmod(self._last_ns, _SECOND)
        state = _WORD.pack(OF_PROGRAM | why | (LOSING if self.drops else 0))
        header = _HEADER.pack(
            V3, _HEADER.size, 0, self._count, self._start, self._used, self._sequence, *first, *last
        )
        memory[place : place + _HEADER.size] = header
        memory[place + _STATE_AT : place + _STATE_AT + len(state)] = state  # last, after everything else
        self.last_at = place + _STATE_AT
        self._block = (self._block + 1) % self._request.blocks
        self._begin()

    def close(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self.memory.close()


def _by_length(rows: Array, addresses: Array) -> Iterator[tuple[Array, Array]]:
    """Runs of frames of one length."""
    edges = (numpy_module().diff(rows["length"].astype("i8")) != 0).nonzero()[0] + 1
    for begin, end in zip([0, *edges], [*edges, len(rows)], strict=True):
        yield rows[begin:end], addresses[begin:end]


def _frame_dtype(request: RingRequest, size: int) -> numpy.dtype:
    """One frame of so many bytes, with struct tpacket3_hdr and struct sockaddr_ll."""
    names = ["next", "seconds", "ns", "snaplen", "len", "status"]
    fields = [(name, "<u4", 4 * at) for at, name in enumerate(names)]
    fields += [("mac", "<u2", 24), ("net", "<u2", 26), ("address", "V20", request.address_at)]
    length = 72 if size - request.data_at >= 72 else 16
    found: numpy.dtype = numpy_module().dtype(
        {
            "names": [name for name, _, _ in fields] + ["data"],
            "formats": [form for _, form, _ in fields] + [("u1", (length,))],
            "offsets": [at for _, _, at in fields] + [request.data_at],
            "itemsize": size,
        }
    )
    return found
