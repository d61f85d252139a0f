"""What the two ends of a network link say to each other, as bytes.

Positions count records from when a ring was opened; a position is the number of records before it. Each payload begins
with its kind; numbers are little-endian.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from canwire.errors import BadMessage

FRAMES, STATES, REPORTS, COUNTS, FAREWELL, CALL, ANSWER, TOGETHER = range(1, 9)

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
STIRS = (1 << 32) - 1  # and of another: how often a timed program was told to look again


class Report(NamedTuple):
    """How far the copy of a ring is: records that came, records taken out; `again`: send anew from `received` on."""

    ring: int
    received: int
    taken: int
    again: bool


class Count(NamedTuple):
    """A FIFO that is only looked at: its counters, and how often the one who says so has put something in."""

    ring: int
    written: int
    taken: int
    lost: int
    own: int


def frames(ring: int, first: int, records: memoryview, stamp: int = 0) -> bytes:
    """A batch of records, or of one notice, from this position on; of commands with when they were given."""
    return b"".join((_HEAD.pack(FRAMES | stamp << 8, ring, first), records))


def frames_in(payload: bytes) -> tuple[int, int, memoryview, int]:
    """Ring, position of the first record, records, stamp; raises BadMessage."""
    if len(payload) < _HEAD.size:
        raise BadMessage(f"a batch of {len(payload)} bytes: {_HEAD.size} at least")
    kind, ring, first = _HEAD.unpack_from(payload)
    return ring, first, memoryview(payload)[_HEAD.size :], kind >> 8


def states(found: list[tuple[int, int]]) -> bytes:
    """Which rings were sent up to which position; none at all is a sign of life."""
    return bytes((STATES,)) + b"".join(_STATE.pack(*state) for state in found)


def states_in(payload: bytes) -> list[tuple[int, int]]:
    """Rings and positions; raises BadMessage."""
    return [(ring, sent) for ring, sent in _each(_STATE, payload)]


def reports(found: list[Report]) -> bytes:
    """How far copies are."""
    return bytes((REPORTS,)) + b"".join(_REPORT.pack(*report) for report in found)


def reports_in(payload: bytes) -> list[Report]:
    """Raises BadMessage."""
    return [
        Report(ring, received, taken, bool(again)) for ring, received, taken, again in _each(_REPORT, payload)
    ]


def counts(found: list[Count]) -> bytes:
    """FIFOs that are only looked at."""
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
    """A call for the first time: a query takes twice as long, but tells when nobody knows this client any more."""
    return bytes((CALL,)) + asked


def answer(answered: bytes) -> bytes:
    """The answer to such a call."""
    return bytes((ANSWER,)) + answered


def packed(payloads: list[bytes]) -> list[bytes]:
    """The same in the same order, small ones together: each that travels alone wakes the other machine up."""
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
    """What went together; raises BadMessage."""
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
