"""A frame bit by bit as it was on the wire; drawing.jinja draws it as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

from canwire import BitLayout, Frame, wire_fields

BITS = 32  # in a row
WIDTH, HEIGHT = 16, 62  # of a bit, of a row
_HIGH, _LOW = 22, 38  # recessive above, dominant below
_SHORT = {"CRC DEL": "DEL", "ACK DEL": "DEL", "DELIMITER": "DEL"}  # where one bit has to do
ERROR_FLAG, ERROR_DELIMITER = 6, 8  # bits (ISO 11898-1:2015 10.4.4)


class Bit(NamedTuple):
    """One bit: 1 is recessive. `kind` is "stuff", "error", "ack" or ""."""

    level: int
    field: str
    kind: str


class Span(NamedTuple):
    """The part of a field in one row: its name above a number of bits from `start` on."""

    name: str
    start: int
    length: int


class Row(NamedTuple):
    """One row of the drawing, from bit `first` on: the fields, the bits, and the level as a line."""

    first: int
    spans: list[Span]
    bits: list[Bit]
    path: str


def bits_of(frame: Frame, error_at: int = -1) -> list[Bit]:
    """Return the bits from SOF to EOF, acknowledged; with `error_at`, up to that bit, then an error
    flag and delimiter."""
    layout = BitLayout(frame)
    layout.levels[layout.ack_slot()] = 0
    bits = [
        Bit(int(level), field.name, "stuff" if stuffed else "ack" if field.name == "ACK" else "")
        for field in wire_fields(layout, frame)
        for level, stuffed in zip(field.bits, field.stuffed, strict=True)
    ]
    if 0 <= error_at < len(bits):
        flag = [Bit(0, "ERROR FLAG", "error")] * ERROR_FLAG
        bits = bits[: error_at + 1] + flag + [Bit(1, "DELIMITER", "error")] * ERROR_DELIMITER
    return bits


def rows_of(bits: Sequence[Bit]) -> list[Row]:
    """Divide the bits into rows of 32."""
    return [
        _row(first, bits[first : first + BITS], bits[first - 1].level if first else 1)
        for first in range(0, len(bits), BITS)
    ]


def _row(first: int, bits: Sequence[Bit], before: int) -> Row:
    spans, start = [], 0
    for name, group in groupby(bits, key=lambda bit: bit.field):
        count = len(list(group))
        spans.append(Span(_SHORT.get(name, name) if count == 1 else name, start, count))
        start += count
    steps = [f"M0 {_height(before)}"]
    for place, bit in enumerate(bits):
        steps.append(f"V{_height(bit.level)}H{(place + 1) * WIDTH}")
    return Row(first, spans, list(bits), "".join(steps))


def _height(level: int) -> int:
    return _HIGH if level else _LOW
