"""LIN frames as levels: which bits a header and a response are made of.

Source: LIN 2.2A 2.3.1; reference/lin-protocol.md sections 1, 2 and 4 (its bit streams come out of here).
"""

from __future__ import annotations

from typing import NamedTuple

from canwire.values.lin.frame import LinFrame, protected_id
from canwire.values.lin.timing import BREAK_BITS, DELIMITER_BITS, SYNC_BYTE, WAKE_BYTE

BREAK, SYNC, SPACE, PID, DATA, WAKE = range(6)


class Field(NamedTuple):
    """A piece that is sent whole: its kind and its levels, a byte (0 dominant, 1 recessive) a bit."""

    kind: int
    levels: bytes


def byte_levels(value: int, stop: int = 1) -> bytes:
    """Start bit, eight bits from the least significant on, stop bit."""
    return bytes([0, *(value >> k & 1 for k in range(8)), stop])


def last_edge_bits(value: int) -> int:
    """Bits from the beginning of a byte to its last edge: where the ones up to the stop bit begin."""
    return 1 + (value ^ 0xFF).bit_length()


def header_fields(
    pid: int,
    *,
    break_bits: int = BREAK_BITS,
    delimiter_bits: int = DELIMITER_BITS,
    space_bits: int = 0,
    sync: int = SYNC_BYTE,
) -> list[Field]:
    """A header; `space_bits` lie between sync field and identifier."""
    fields = [
        Field(BREAK, bytes(break_bits) + b"\1" * delimiter_bits),
        Field(SYNC, byte_levels(sync)),
    ]
    return [*fields, *_space(space_bits), Field(PID, byte_levels(pid))]


def response_fields(octets: bytes, *, space_bits: int = 0, gap_bits: int = 0) -> list[Field]:
    """Data and checksum, `space_bits` before the first byte and `gap_bits` between any two."""
    fields = _space(space_bits)
    for number, octet in enumerate(octets):
        if number:
            fields += _space(gap_bits)
        fields.append(Field(DATA, byte_levels(octet)))
    return fields


def wake_fields() -> list[Field]:
    """The wake-up pulse: five dominant bits."""
    return [Field(WAKE, byte_levels(WAKE_BYTE))]


def frame_levels(frame: LinFrame) -> bytes:
    """A frame without spaces, bit by bit; of a header alone only that."""
    fields = header_fields(protected_id(frame.id))
    if not frame.header_only:
        fields += response_fields(frame.data + bytes([frame.checksum]))
    return b"".join(field.levels for field in fields)


def _space(bits: int) -> list[Field]:
    return [Field(SPACE, b"\1" * bits)] if bits else []
