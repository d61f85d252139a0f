"""Buses of a hub whose lines disagree about the bit rate."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.boards.can.rates import RateConflict, RunningLine, rate_conflicts
from canwire.hub.finding import every_line, lines_now

if TYPE_CHECKING:
    from collections.abc import Iterator

    from canwire.hub.handles.hub import Hub


def conflicts_on(hub: Hub, bus: str | None = None) -> list[RateConflict]:
    """Every bus with lines at different rates, or only this one; str() of each is a sentence for people."""
    return [found for found in rate_conflicts(_lines(hub)) if bus in (None, found.bus)]


def _lines(hub: Hub) -> Iterator[RunningLine]:
    for place, status in lines_now(hub, every_line(hub, "CAN")):
        yield RunningLine(place.address, place.info.bus, status)
