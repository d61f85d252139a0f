"""The payloads that the two ends of a network link exchange, as bytes.

Positions count records from when a ring was opened; a position is the number of records before it. Each payload begins
with its kind; numbers are little-endian.
"""

from __future__ import annotations

import struct
import zlib
from typing import NamedTuple

from canwire.errors import BadMessage
from canwire.values.packed_records import pack, unpack

FRAMES, STATES, REPORTS, COUNTS, FAREWELL, CALL, ANSWER, TOGETHER, PACKED, SQUEEZED = range(1, 11)
BATCHES = (FRAMES, PACKED, SQUEEZED)
_SQUEEZE = (1, zlib.DEFLATED, -12, 5)  # quick to begin with: a batch has few KB, and zlib's usual tables 256
_LARGEST = 1 << 17  # bytes of packed records

_HEAD = struct.Struct("<IIQ")  # kind and, above it, a stamp (cuts/age.py); ring; position of the first record
_STATE = struct.Struct("<IQ")
_REPORT = struct.Struct("<IQQ?")
_COUNT = struct.Struct("<IQQQQ")
_LENGTH = struct.Struct("<I")
SMALL = 1_024  # bytes of a payload that goes together with others
_MOST = 32  # of them
NOTES = 0  # the number of what is no ring: notices, in their order
CLOCK = (1 << 32) - 3  # of no ring: in a sign of life, its sender's clock in ns
SILENCE = (1 << 32) - 2  # of no ring either: in a sign of life, for how many ns its sender has heard nothing
STIRS = (1 << 32) - 1  # and of another: how often a timed program was woken to check again


class Report(NamedTuple):
    """The state of a ring's copy: records received, records read from it; `again`: send again from `received` on."""

    ring: int
    received: int
    taken: int
    again: bool


class Count(NamedTuple):
    """A FIFO that is only monitored: its counters, and how many elements the sender of this has put in."""

    ring: int
    written: int
    taken: int
    lost: int
    own: int


def frames(ring: int, first: int, records: memoryview, stamp: int = 0) -> bytes:
    """A batch of records, or of one notice, from this position on; for commands, with the time they were given."""
    return b"".join((_HEAD.pack(FRAMES | stamp << 8, ring, first), records))


def packed_frames(
    ring: int, first: int, records: memoryview, stamp: int = 0, *, squeeze: bool = False
) -> bytes:
    """The same for records of frames, packed; for a slow network also compressed, if that makes it smaller."""
    small = pack(bytearray(records))
    if squeeze:
        work = zlib.compressobj(*_SQUEEZE)
        squeezed = work.compress(small) + work.flush()
    if squeeze and len(squeezed) < len(small):
        return b"".join((_HEAD.pack(SQUEEZED | stamp << 8, ring, first), squeezed))
    return b"".join((_HEAD.pack(PACKED | stamp << 8, ring, first), small))


def frames_in(payload: bytes) -> tuple[int, int, memoryview, int]:
    """Ring, position of the first record, records, stamp, from any of these forms; raises BadMessage."""
    if len(payload) < _HEAD.size:
        raise BadMessage(f"a batch of {len(payload)} bytes: {_HEAD.size} at least")
    kind, ring, first = _HEAD.unpack_from(payload)
    rest = memoryview(payload)[_HEAD.size :]
    if kind & 0xFF == PACKED:
        rest = memoryview(unpack(bytes(rest)))
    elif kind & 0xFF == SQUEEZED:
        rest = memoryview(unpack(_let_out(rest)))
    return ring, first, rest, kind >> 8


def _let_out(squeezed: memoryview) -> bytes:
    """Decompress a message; a few bytes that claim to be megabytes are refused."""
    out = zlib.decompressobj(-zlib.MAX_WBITS)
    try:
        found = out.decompress(squeezed, _LARGEST)
    except zlib.error as error:
        raise BadMessage(f"a squeezed batch of {len(squeezed)} bytes: {error}") from None
    if not out.eof or out.unused_data:
        raise BadMessage(
            f"a squeezed batch of {len(squeezed)} bytes: not whole, or more than {_LARGEST} bytes"
        )
    return found


def states(found: list[tuple[int, int]]) -> bytes:
    """Which rings were sent up to which position; none at all is a sign of life."""
    return bytes((STATES,)) + b"".join(_STATE.pack(*state) for state in found)


def states_in(payload: bytes) -> list[tuple[int, int]]:
    """Rings and positions; raises BadMessage."""
    return [(ring, sent) for ring, sent in _each(_STATE, payload)]


def reports(found: list[Report]) -> bytes:
    """Reports on the copies of rings."""
    return bytes((REPORTS,)) + b"".join(_REPORT.pack(*report) for report in found)


def reports_in(payload: bytes) -> list[Report]:
    """Raises BadMessage."""
    return [
        Report(ring, received, taken, bool(again)) for ring, received, taken, again in _each(_REPORT, payload)
    ]


def counts(found: list[Count]) -> bytes:
    """The counts of FIFOs that are only monitored."""
    return bytes((COUNTS,)) + b"".join(_COUNT.pack(*count) for count in found)


def counts_in(payload: bytes) -> list[Count]:
    """Raises BadMessage."""
    return [Count(*count) for count in _each(_COUNT, payload)]


def farewell(text: str) -> bytes:
    """The last words of this end."""
    return bytes((FAREWELL,)) + text.encode()


def farewell_in(payload: bytes) -> str:
    return payload[1:].decode(errors="replace")


def call(asked: bytes) -> bytes:
    """The first attempt of a call: a query takes twice as long, but shows if the hub no longer knows this client."""
    return bytes((CALL,)) + asked


def answer(answered: bytes) -> bytes:
    """The answer to such a call."""
    return bytes((ANSWER,)) + answered


def packed(payloads: list[bytes]) -> list[bytes]:
    """The same payloads in the same order, with small ones combined: each separate one wakes the other machine."""
    found: list[bytes] = []
    small: list[bytes] = []
    for payload in payloads:
        if len(payload) > SMALL or len(small) == _MOST:
            found += _together(small)
            small = []
        if len(payload) > SMALL:
            found.append(payload)
        else:
            small.append(payload)
    return found + _together(small)


def parts_in(payload: bytes) -> list[bytes]:
    """The payloads of a combined one; raises BadMessage."""
    found, at = [], 1
    while at < len(payload):
        begin = at + _LENGTH.size
        if begin > len(payload) or (end := begin + _LENGTH.unpack_from(payload, at)[0]) > len(payload):
            raise BadMessage(f"payloads together, {len(payload)} bytes: the one at {at} is longer than that")
        if payload[begin:end][:1] == bytes((TOGETHER,)):
            raise BadMessage("payloads together within others")
        found.append(payload[begin:end])
        at = end
    return found


def _together(payloads: list[bytes]) -> list[bytes]:
    if len(payloads) < 2:
        return payloads
    parts = [part for payload in payloads for part in (_LENGTH.pack(len(payload)), payload)]
    return [b"".join((bytes((TOGETHER,)), *parts))]


def _each(form: struct.Struct, payload: bytes) -> list[tuple[int, ...]]:
    try:
        return list(form.iter_unpack(memoryview(payload)[1:]))
    except struct.error:
        raise BadMessage(f"a message of {len(payload)} bytes: not 1 and a multiple of {form.size}") from None
