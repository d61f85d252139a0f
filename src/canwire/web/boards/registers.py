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
        values = registers_now(hub, place)
        if values:
            found.append(Chip(place, values))
    return found


def registers_now(hub: Hub, place: LinePlace) -> tuple[RegisterValue, ...]:
    """Read the registers of one line; () if the controller has none, or its board has been unplugged."""
    try:
        return hub.registers(place.board.id, place.line)
    except (NoSuchBoard, Unplugged):
        return ()
