"""The registers of every chip that has registers, read without side effects."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from canwire import LinePlace, NoSuchBoard, RegisterValue, Unplugged, every_line

if TYPE_CHECKING:
    from collections.abc import Collection

    from canwire import Hub


class Chip(NamedTuple):
    """The chip of one line."""

    place: LinePlace
    registers: tuple[RegisterValue, ...]


def registers_of(hub: Hub, boards: Collection[int]) -> list[Chip]:
    """Read the registers of the CAN lines of these boards (their numbers at the hub), if the
    controller has registers."""
    found = []
    for place in every_line(hub, "CAN"):
        if place.board.id not in boards:
            continue
        try:
            values = hub.registers(place.board.id, place.line)
        except (NoSuchBoard, Unplugged):
            continue
        if values:
            found.append(Chip(place, values))
    return found
