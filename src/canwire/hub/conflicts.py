"""Find lines of a hub whose settings could not work together on a real bus."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.boards.can.rates import Conflict, RunningLine, bus_conflicts
from canwire.hub.finding import LinePlace, every_line, lines_now

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from canwire.hub.handles.hub import Hub


def conflicts_on(
    hub: Hub, bus: str | None = None, *, among: Sequence[LinePlace] | None = None
) -> list[Conflict]:
    """Conflicts that would stop a real bus from working, on every bus or on `bus`; str() of each is a sentence.

    A RateConflict means lines at different rates. A TimingConflict means timings of one rate that break a rule of
    ISO 11898-1.

    `among` are the lines that `every_line` has found already.
    """
    lines = every_line(hub) if among is None else among
    can = [place for place in lines if place.info.bus_type == "CAN" and bus in (None, place.info.bus)]
    return bus_conflicts(_running(hub, can))


def _running(hub: Hub, places: Sequence[LinePlace]) -> Iterator[RunningLine]:
    for place, status in lines_now(hub, places):
        yield RunningLine(place.address, place.info.bus, status)
