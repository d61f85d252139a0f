"""The registers of every chip that has some, read without side effects."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from canwire import LinePlace, NoSuchBoard, RegisterValue, Unplugged, every_line

if TYPE_CHECKING:
    from canwire import Hub


class Chip(NamedTuple):
    """One line's chip."""

    place: LinePlace
    registers: tuple[RegisterValue, ...]


def registers_of(hub: Hub) -> list[Chip]:
    """Of all CAN lines whose controller has registers."""
    found = []
    for place in every_line(hub, "CAN"):
        try:
            values = hub.registers(place.board.id, place.line)
        except (NoSuchBoard, Unplugged):
            continue
        if values:
            found.append(Chip(place, values))
    return found
