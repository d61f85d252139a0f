# cython: nonecheck=False
"""The SJA1000's acceptance filter: BasicCAN's, and PeliCAN's single and dual one.

Source: data sheet 6.3.9, 6.4.15; reference/sja1000.md section 9.
"""

from __future__ import annotations

from canwire import _mem

_EXTENDED, _REMOTE = 1 << 23, 1 << 22  # info bits of a record
BASIC_FILTER, SINGLE_FILTER, DUAL_FILTER = range(3)
_BASIC, _SINGLE = BASIC_FILTER, SINGLE_FILTER
# what is compared at all: ACR0 in bits 31 to 24, ACR3 in bits 7 to 0
_SINGLE_STANDARD, _SINGLE_EXTENDED = 0xFFF0FFFF, 0xFFFFFFFC
_FIRST_STANDARD, _FIRST_EXTENDED = 0xFFFF000F, 0xFFFF0000
_ONE_BYTE, _NO_BYTE = 0xFFF0FF00, 0xFFF00000


class AcceptanceFilter:
    """ACR and AMR as numbers of 32 bits, ACR0 first; a bit of `care` is 1 where AMR's is 0."""

    def __init__(self) -> None:
        self.mode = _BASIC
        self.code = 0
        self.care = 0

    def accepts(self, words: _mem.Words) -> bool:
        """Whether the frame in this record passes the filter."""
        head = words[1]
        info = head >> 32
        identifier = head & 0x1FFFFFFF
        if self.mode == _BASIC:
            return not info & _EXTENDED and (identifier >> 3 ^ self.code >> 24) & self.care >> 24 == 0
        remote = 1 if info & _REMOTE else 0
        if self.mode == _SINGLE and info & _EXTENDED:
            key = identifier << 3 | remote << 2
            return (key ^ self.code) & self.care & _SINGLE_EXTENDED == 0
        if info & _EXTENDED:
            half = identifier >> 13
            first = (half << 16 ^ self.code) & self.care & _FIRST_EXTENDED
            return first == 0 or (half ^ self.code) & self.care & 0xFFFF == 0
        length = 0 if remote else info >> 16 & 15
        return self._standard(identifier, remote, length, words[2] & 0xFFFF)

    def _standard(self, identifier: int, remote: int, length: int, data: int) -> bool:
        """Whether an 11-bit frame passes; `data` has its first byte in bits 7 to 0. Missing bytes match."""
        byte = data & 255
        if self.mode == _SINGLE:
            care = self.care & _SINGLE_STANDARD
            if length < 2:
                care &= _ONE_BYTE if length else _NO_BYTE
            key = identifier << 21 | remote << 20 | byte << 8 | data >> 8
            return (key ^ self.code) & care == 0
        care = self.care & (_FIRST_STANDARD if length else _NO_BYTE)
        key = identifier << 21 | remote << 20 | byte >> 4 << 16 | byte & 15
        if (key ^ self.code) & care == 0:
            return True
        return ((identifier << 5 | remote << 4) ^ self.code) & self.care & 0xFFF0 == 0
