"""LIN frames as levels: the bits of a header and of a response.

Source: LIN 2.2A 2.3.1; reference/lin-protocol.md sections 1, 2 and 4 (this file computes its bit streams).
"""

from __future__ import annotations

from typing import NamedTuple

from canwire.values.lin.frame import LinFrame, protected_id
from canwire.values.lin.timing import BREAK_BITS, DELIMITER_BITS, SYNC_BYTE, WAKE_BYTE

BREAK, SYNC, SPACE, PID, DATA, WAKE = range(6)


class Field(NamedTuple):
    """A part of a frame that is sent without interruption: its kind, and one byte for each level (0 dominant, 1
    recessive).
    """

    kind: int
    levels: bytes


def byte_levels(value: int, stop: int = 1) -> bytes:
    """The levels of a byte: start bit, eight bits from the least significant on, stop bit."""
    return bytes([0, *(value >> k & 1 for k in range(8)), stop])


def last_edge_bits(value: int) -> int:
    """Bits from the beginning of a byte to its last edge, where the ones up to the stop bit begin."""
    return 1 + (value ^ 0xFF).bit_length()


def header_fields(
    pid: int,
    *,
    break_bits: int = BREAK_BITS,
    delimiter_bits: int = DELIMITER_BITS,
    space_bits: int = 0,
    sync: int = SYNC_BYTE,
) -> list[Field]:
    """The fields of a header; `space_bits` are between sync field and identifier."""
    fields = [
        Field(BREAK, bytes(break_bits) + b"\1" * delimiter_bits),
        Field(SYNC, byte_levels(sync)),
    ]
    return [*fields, *_space(space_bits), Field(PID, byte_levels(pid))]


def response_fields(octets: bytes, *, space_bits: int = 0, gap_bits: int = 0) -> list[Field]:
    """The fields of data and checksum, `space_bits` before the first byte and `gap_bits` between any two."""
    fields = _space(space_bits)
    for number, octet in enumerate(octets):
        if number:
            fields += _space(gap_bits)
        fields.append(Field(DATA, byte_levels(octet)))
    return fields


def wake_fields() -> list[Field]:
    """The fields of the wake-up pulse: five dominant bits."""
    return [Field(WAKE, byte_levels(WAKE_BYTE))]


def frame_levels(frame: LinFrame) -> bytes:
    """The levels of a frame without spaces, bit by bit; only those of the header if the frame is a header alone."""
    fields = header_fields(protected_id(frame.id))
    if not frame.header_only:
        fields += response_fields(frame.data + bytes([frame.checksum]))
    return b"".join(field.levels for field in fields)


def _space(bits: int) -> list[Field]:
    return [Field(SPACE, b"\1" * bits)] if bits else []
