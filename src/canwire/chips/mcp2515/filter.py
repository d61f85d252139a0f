"""The MCP2515's acceptance: six filters and two masks, and which receive buffer a frame goes to.

Source: DS20001801 chapter 4.5, registers 4-1, 4-2 and 4-10 to 4-17.

Interpretations [INT] where the data sheet is silent:
- Of data bytes that a standard frame does not have, nothing is compared.
- RXF0 (in RXB1: RXF2) is said to have matched where filters are switched off.
"""

from __future__ import annotations

from typing import NamedTuple

from canwire.chips.mcp2515 import register_map as m

_FILTERS_OF = ((0, 1), (2, 3, 4, 5))
_ALL, _STANDARD, _EXTENDED = m.RXM_ALL, m.RXM_STANDARD, m.RXM_EXTENDED


class Pattern(NamedTuple):
    """A filter or a mask: the identifier's 29 bits, and whether a filter is for extended frames."""

    bits: int
    extended: bool

    @classmethod
    def of(cls, cells: bytes | bytearray, at: int) -> Pattern:
        high, low, eid8, eid0 = cells[at : at + 4]
        return cls(high << 21 | low >> 5 << 18 | (low & 3) << 16 | eid8 << 8 | eid0, bool(low & m.SIDL_EXIDE))


class Acceptance:
    """Filters and masks with the values at the end of configuration mode."""

    def __init__(self) -> None:
        self.filters = [Pattern(0, False)] * len(m.RXF)
        self.masks = [0] * len(m.RXM)

    def load(self, cells: bytes | bytearray) -> None:
        """Load filters and masks from the chip's registers."""
        self.filters = [Pattern.of(cells, at) for at in m.RXF]
        self.masks = [Pattern.of(cells, at).bits for at in m.RXM]

    def hit(self, buffer: int, mode: int, id: int, extended: bool, data: bytes) -> int:
        """The number of the first filter that accepts a frame for a receive buffer, or -1.

        `mode` is the buffer's RXM; `data` are the bytes of a data frame, b"" for a remote frame.
        """
        numbers = _FILTERS_OF[buffer]
        if mode == _ALL:
            return numbers[0]
        if mode == (_STANDARD if extended else _EXTENDED):
            return -1
        care = self.masks[buffer]
        if extended:
            seen = id
        else:
            seen = id << 18
            first, second = data[:1], data[1:2]
            compared = 0x1FFC0000
            if mode != _STANDARD:
                if first:
                    seen |= first[0] << 8
                    compared |= 0xFF00
                if second:
                    seen |= second[0]
                    compared |= 0x00FF
            care &= compared
        for number in numbers:
            pattern = self.filters[number]
            if pattern.extended is extended and not (pattern.bits ^ seen) & care:
                return number
        return -1
