"""A frame on a cyclic list, and the part of it that grows by one after each transmission.

Source: VCI V4 manual 7.3.17; rulings.md 9.
"""

from __future__ import annotations

from dataclasses import dataclass

from canwire.boards.can.channel import Channel
from canwire.errors import BadValue
from canwire.values.frame import Frame, frame_of_record, record_of_frame
from canwire.values.named import NamedInt

_ID_AT, _DATA_AT = 8, 16  # in a record


class Increment(NamedInt):
    """The part of a frame that grows by one after each transmission; the numbers are CAN_CTXMSG_INC_*."""

    NONE = 0
    ID = 1
    BYTE = 2
    WORD = 3


class CyclicState(NamedInt):
    """The state of an entry of the list; the numbers are CAN_CTXMSG_STAT_*."""

    EMPTY = 0
    BUSY = 1
    DONE = 2


@dataclass(slots=True)
class CyclicObject:
    """One frame on the list.

    `due` is the ideal tick of the oldest occurrence not served; `left` is 0 for an endless object.
    `growing` is the number that `successor` increments: offset in the frame's record, size, modulus.
    """

    frame: Frame
    cycle: int
    flags: int
    growing: tuple[int, int, int] | None
    channel: Channel
    state: CyclicState = CyclicState.EMPTY
    left: int = 0
    due: int = 0


def growing(frame: Frame, increment: Increment, byte_index: int) -> tuple[int, int, int] | None:
    """The position of the part of the frame's record that grows; None if nothing grows. Raises BadValue."""
    if increment == Increment.NONE:
        return None
    if increment == Increment.ID:
        return _ID_AT, 4, 1 << 29 if frame.extended else 1 << 11
    if increment not in (Increment.BYTE, Increment.WORD):
        raise BadValue(f"increment {increment!r}: from 0 to 3")
    size = 1 if increment == Increment.BYTE else 2
    last = len(frame.data) - size
    if last < 0:
        raise BadValue(f"increment {increment!r} in a frame with {len(frame.data)} bytes of data")
    if not isinstance(byte_index, int) or not 0 <= byte_index <= last:
        raise BadValue(f"byte_index {byte_index!r}: from 0 to {last} with {len(frame.data)} bytes of data")
    return _DATA_AT + byte_index, size, 1 << 8 * size


def successor(frame: Frame, at: int, size: int, modulus: int) -> Frame:
    """The frame after one transmission: a little-endian number in its record is increased by one, and wraps to 0."""
    record = bytearray(record_of_frame(frame))
    where = slice(at, at + size)
    value = (int.from_bytes(record[where], "little") + 1) % modulus
    record[where] = value.to_bytes(size, "little")
    return frame_of_record(record)
