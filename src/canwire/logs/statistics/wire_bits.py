"""Counts the bits of many frames on the wire, including stuff bits.

`bus/can/bits.py` measures frame by frame, compiled; this file uses numpy, column by column, whether or not the core is
compiled. Tests compare both. Source: ISO 11898-1:2015 chapters 8.4 and 10.4.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from canwire.bus.can.bits import CRC15_POLY, START_STATE
from canwire.values.dlc import FD_LENGTHS
from canwire.values.record import (
    DLC_SHIFT,
    ERROR_STATE_INDICATOR,
    EXTENDED,
    EXTENDED_DATA_LENGTH,
    FAST_DATA_RATE,
    REMOTE,
    load_numpy,
)

if TYPE_CHECKING:
    import numpy

INTERMISSION = 3
"""Bits after a frame that belong to its time: no other frame can use them."""
_TAIL = 10  # CRC delimiter, ACK slot, ACK delimiter, EOF
_KIND = EXTENDED | REMOTE | EXTENDED_DATA_LENGTH | FAST_DATA_RATE | 15 << DLC_SHIFT


def wire_bits(records: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Return the bits of each CAN frame with its intermission, and how many of them use the data bit rate (BRS).

    Frames whose heads differ only in the identifier are computed together; `records` are of `log_dtype()` or
    `record_dtype()`.
    """
    numpy = load_numpy()
    bits = numpy.zeros(len(records), numpy.int64)
    fast = numpy.zeros(len(records), numpy.int64)
    kinds = records["info"] & numpy.uint32(_KIND)
    for kind in _different(kinds):
        those = slice(None) if len(records) and (kinds == kind).all() else numpy.flatnonzero(kinds == kind)
        measure = _measure_fd if kind & EXTENDED_DATA_LENGTH else _measure_classic
        bits[those], fast[those] = measure(records[those], int(kind))
    return bits + INTERMISSION, fast


def _different(kinds: numpy.ndarray) -> list[int]:
    """Return the different values without sorting all of them: the frame bits of info fit in 16 bits."""
    numpy = load_numpy()
    low = kinds >> numpy.uint32(10)  # bits 10 to 23
    found = numpy.flatnonzero(numpy.bincount(low, minlength=1))
    return [int(one) << 10 for one in found]


class _Stuffing:
    """Counts the stuff bits of many frames, some bits of each frame at a time."""

    def __init__(self, count: int) -> None:
        numpy = load_numpy()
        self._step = numpy.full(count, START_STATE, numpy.uint16)
        self.count = numpy.zeros(count, numpy.uint16)

    def feed(self, bits: numpy.ndarray, width: int) -> None:
        """Process the next `width` bits of each frame, 8 at most."""
        numpy = load_numpy()
        self._step &= numpy.uint16(0xF00)
        self._step |= bits
        self._step = _stuff_table(width)[self._step]
        self.count += self._step & numpy.uint16(15)

    def end(self) -> None:
        """Count the stuff bit after a run of five bits at the end of the stuffed part."""
        numpy = load_numpy()
        self.count += (self._step & numpy.uint16(0x700)) == 0x500


def _measure_classic(records: numpy.ndarray, kind: int) -> tuple[numpy.ndarray, int]:
    numpy = load_numpy()
    code = kind >> DLC_SHIFT & 15
    remote = bool(kind & REMOTE)
    length = 0 if remote else min(code, 8)
    head = records["id"].astype(numpy.uint64)
    if kind & EXTENDED:
        head = (head >> 18 << 20 | 3 << 18 | head & 0x3FFFF) << 7 | (remote << 6 | code)
        heads = [(head >> 32, 7), (head >> 24 & 255, 8), (head >> 16 & 255, 8)]
        bits = 64 + 8 * length
    else:
        head = head << 7 | (remote << 6 | code)
        heads = [(head >> 16 & 7, 3)]
        bits = 44 + 8 * length
    heads += [(head >> 8 & 255, 8), (head & 255, 8)]
    stuffing = _Stuffing(len(records))
    crc = numpy.zeros(len(records), numpy.uint16)
    columns = [(one.astype(numpy.uint16), width) for one, width in heads]
    columns += [(column.astype(numpy.uint16), 8) for column in records["data"][:, :length].T]
    for column, width in columns:
        stuffing.feed(column, width)
        crc = (crc << 8 & 0x7F00) ^ _crc_table()[(crc >> 7 ^ column) & 255]
    stuffing.feed(crc >> 8, 7)
    stuffing.feed(crc & 255, 8)
    stuffing.end()
    return bits + stuffing.count.astype(numpy.int64), 0


def _measure_fd(records: numpy.ndarray, kind: int) -> tuple[numpy.ndarray, numpy.ndarray | int]:
    numpy = load_numpy()
    code = kind >> DLC_SHIFT & 15
    switch = bool(kind & FAST_DATA_RATE)
    length = FD_LENGTHS[code]
    head = records["id"].astype(numpy.uint64)
    if kind & EXTENDED:
        head = (head >> 18 << 20 | 3 << 18 | head & 0x3FFFF) << 4 | (4 | switch)
        heads = [(head >> 32 & 15, 4), (head >> 24 & 255, 8), (head >> 16 & 255, 8)]
        bits = 41
    else:
        head = head << 5 | (4 | switch)
        heads = [(head >> 16 & 1, 1)]
        bits = 22
    stuffing = _Stuffing(len(records))
    for one, width in [*heads, (head >> 8 & 255, 8), (head & 255, 8)]:
        stuffing.feed(one.astype(numpy.uint16), width)
    nominal = bits - 5 + stuffing.count.astype(numpy.int64)
    esi = records["info"] & numpy.uint32(ERROR_STATE_INDICATOR) != 0
    stuffing.feed(numpy.where(esi, 16 | code, code).astype(numpy.uint16), 5)
    for column in records["data"][:, :length].T:
        stuffing.feed(column.astype(numpy.uint16), 8)
    crc_field = 27 if length <= 16 else 32
    every = bits + 8 * length + stuffing.count.astype(numpy.int64) + crc_field + _TAIL
    return every, every - _TAIL - nominal if switch else 0


@cache
def _stuff_table(width: int) -> numpy.ndarray:
    """By state << 8 | bits: the next state << 8 | stuff bits inserted. A state is the last bit << 3 | its run, 0..5."""
    numpy = load_numpy()
    state, bits = numpy.arange(16)[:, None], numpy.arange(256)[None, :]
    last, run = numpy.broadcast_arrays(state >> 3, state & 7 | bits & 0)
    count = numpy.zeros((16, 256), int)
    for at in reversed(range(width)):
        full = run == 5
        last, run, count = numpy.where(full, 1 - last, last), numpy.where(full, 1, run), count + full
        bit = bits >> at & 1
        run = numpy.where((bit == last) & (run > 0), numpy.minimum(run + 1, 5), 1)
        last = numpy.broadcast_to(bit, run.shape)
    return ((last << 3 | run) << 8 | count).ravel().astype(numpy.uint16)


@cache
def _crc_table() -> numpy.ndarray:
    numpy = load_numpy()
    register = numpy.arange(256) << 7
    for _ in range(8):
        register = (register << 1) ^ numpy.where(register & 0x4000, CRC15_POLY, 0)
    return (register & 0x7FFF).astype(numpy.uint16)
