"""The part of a line's filter that fits into the SJA1000's acceptance registers: two filters of 16 bits each.

A filter compares the identifier and RTR of a standard frame (data is not compared here), and only the upper 16
identifier bits of an extended frame (source: SJA1000 data sheet 6.4.15, dual filter; reference/sja1000.md). Every
wanted frame passes; the line filters out the unwanted ones that pass too.
"""

from __future__ import annotations

Pattern = tuple[int, int]  # code, mask of id << 1 | remote; a bit of the mask: compared

_DATA_NIBBLE = 0xF  # of the first data byte: in both filters' lowest bits
_ALL = (0x00000000, 0xFFFFFFFF)


def pushed(standard: Pattern | None, extended: Pattern | None) -> tuple[int, int]:
    """AC0..3 and AM0..3 (a set bit in AM is not compared). A pattern is None if no frame of that format is wanted."""
    one = None if standard is None else (standard[0] << 4, standard[1] << 4)
    other = None if extended is None else (extended[0] >> 14, extended[1] >> 14)
    first, second = one or other, other or one
    if first is None or second is None:
        return _ALL
    if one is not None:
        second = second[0], second[1] & ~_DATA_NIBBLE
    code = (first[0] & first[1]) << 16 | (second[0] & second[1])
    return code, ~(first[1] << 16 | second[1]) & 0xFFFFFFFF
