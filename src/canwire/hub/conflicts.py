"""Buses of a hub whose lines disagree about the bit rate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.boards.can.rates import RateConflict, RunningLine, rate_conflicts
from canwire.hub.finding import LinePlace, every_line, lines_now

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from canwire.hub.handles.hub import Hub


def conflicts_on(
    hub: Hub, bus: str | None = None, *, among: Sequence[LinePlace] | None = None
) -> list[RateConflict]:
    """Every bus with lines at different rates, or only this one; str() of each is a sentence for people.

    `among` are the lines that `every_line` has found already.
    """
    lines = every_line(hub) if among is None else among
    can = [place for place in lines if place.info.bus_type == "CAN" and bus in (None, place.info.bus)]
    return rate_conflicts(_running(hub, can))


def _running(hub: Hub, places: Sequence[LinePlace]) -> Iterator[RunningLine]:
    for place, status in lines_now(hub, places):
        yield RunningLine(place.address, place.info.bus, status)
