"""A line's filter in the SJA1000's acceptance registers, as far as it fits: two filters of 16 bits each.

A filter sees a standard frame's identifier and RTR (and data, which is not compared here), of an extended one only
the upper 16 identifier bits (source: SJA1000 data sheet 6.4.15, dual filter; reference/sja1000.md). What passes here
and should not is stopped by the line; nothing that should pass is held up.
"""

from __future__ import annotations

Pattern = tuple[int, int]  # code, mask of id << 1 | remote; a bit of the mask: compared

_DATA_NIBBLE = 0xF  # of the first data byte: in both filters' lowest bits
_ALL = (0x00000000, 0xFFFFFFFF)


def pushed(standard: Pattern | None, extended: Pattern | None) -> tuple[int, int]:
    """AC0..3 and AM0..3 (there, a set bit is not compared); None where no frame of that format is wanted."""
    one = None if standard is None else (standard[0] << 4, standard[1] << 4)
    other = None if extended is None else (extended[0] >> 14, extended[1] >> 14)
    first, second = one or other, other or one
    if first is None or second is None:
        return _ALL
    if one is not None:
        second = second[0], second[1] & ~_DATA_NIBBLE
    code = (first[0] & first[1]) << 16 | (second[0] & second[1])
    return code, ~(first[1] << 16 | second[1]) & 0xFFFFFFFF
