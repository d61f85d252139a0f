"""Which bit of a frame a place is."""

from __future__ import annotations

from canwire import BitLayout, Frame
from canwire.bus.can.faults.places import Place
from tests.cases import each

ONE_BYTE = BitLayout(Frame(0x555, b"\x55"))  # one stuff bit before the data, none in them
NO_DATA = BitLayout(Frame(0x555))


@each(
    ("place", "layout", "index"),
    [
        (Place("frame", 0), ONE_BYTE, 0),
        (Place("frame", 7), ONE_BYTE, 7),
        (Place("data", 1), ONE_BYTE, 20),
        (Place("data", 8), ONE_BYTE, 27),
        (Place("data", 9), ONE_BYTE, -1),  # it has 8 bits of data
        (Place("data", 1), NO_DATA, -1),
        (Place("intermission", 1), ONE_BYTE, -1),
    ],
)
def test_index(place: Place, layout: BitLayout, index: int) -> None:
    assert place.index_in(layout) == index
