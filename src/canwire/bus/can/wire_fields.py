"""The fields of a frame as on the wire, stuff bits included, for drawing and printing.

Source: ISO 11898-1:2015 chapter 10.4.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from typing import NamedTuple

from canwire.bus.can.bit_layout import FIELDS, BitLayout
from canwire.values.frame import Frame


class WireField(NamedTuple):
    """A stretch of the frame; `bits` has its stuff bits too, and `stuffed` a 1 at each of them."""

    name: str
    start: int
    bits: str
    stuffed: bytes

    @property
    def marked(self) -> str:
        """The bits with stuff bits in parentheses."""
        return "".join(f"({bit})" if stuff else bit for bit, stuff in self._pairs())

    @property
    def value(self) -> int:
        """The number in the field, stuff bits left out."""
        return int("".join(bit for bit, stuff in self._pairs() if not stuff), 2)

    @property
    def stuff_places(self) -> list[int]:
        """The positions of the stuff bits, counted from SOF."""
        return [self.start + k for k, stuff in enumerate(self.stuffed) if stuff]

    def _pairs(self) -> Iterator[tuple[str, int]]:
        return zip(self.bits, self.stuffed, strict=True)


def wire_fields(layout: BitLayout, frame: Frame) -> list[WireField]:
    """The frame's fields in order, under the names that they have in this format."""
    found = []
    for index, group in groupby(range(len(layout.levels)), key=layout.fields.__getitem__):
        places = list(group)
        bits = "".join(str(layout.levels[k]) for k in places)
        stuffed = bytes(layout.stuffed[k] for k in places)
        found.append(WireField(_name(FIELDS[index], frame), places[0], bits, stuffed))
    return found


def _name(field: str, frame: Frame) -> str:
    """ISO's name: some bits are called differently in each format."""
    if field == "RTR":
        return "SRR" if frame.extended else "RRS" if frame.fd else "RTR"
    if field == "RTR2":
        return "RRS" if frame.fd else "RTR"
    if field == "FDF" and not frame.fd:
        return "r1" if frame.extended else "r0"
    return {"EXT": "ID EXT"}.get(field, field)
