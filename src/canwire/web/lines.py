"""Returns the present state of every line of the hub, for all views."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from canwire import (
    BoardInfo,
    ErrorState,
    LinePlace,
    LineStatus,
    LinLineStatus,
    LinState,
    NoSuchBoard,
    every_line,
)

if TYPE_CHECKING:
    from collections.abc import Collection

    from canwire import Hub


class LinUse(NamedTuple):
    """The state of a LIN line, and the program that has its control."""

    status: LinLineStatus
    control_holder: str


class Line(NamedTuple):
    """One line and its status; exactly one of `can` and `lin` is not None."""

    place: LinePlace
    can: LineStatus | None
    lin: LinUse | None

    @property
    def running(self) -> bool:
        return self.can.running if self.can is not None else self.lin is not None and self.lin.status.running

    @property
    def lateness(self) -> str:
        """A sentence about a hub whose buses cannot keep up with the clock; "" if they keep up."""
        if self.can is not None:
            return self.can.lateness
        return "" if self.lin is None else self.lin.status.lateness

    @property
    def state(self) -> str:
        """The key of a text: "error-active", "stopped", "not-initialised", "shorted", ..."""
        if self.can is not None:
            if not self.can.initialised:
                return "not-initialised"
            return "shorted" if self.can.coupling_fault else _key(ErrorState(self.can.state).name)
        assert self.lin is not None
        status = self.lin.status
        return "lin-" + _key(LinState(status.state).name) if status.initialised else "not-initialised"


def _key(name: str) -> str:
    return name.lower().replace("_", "-")


def look(hub: Hub, boards: Collection[int] | None = None) -> list[Line]:
    """Return the lines of these boards (their numbers; None: all boards), without boards that are
    unplugged meanwhile."""
    places = [place for place in every_line(hub) if boards is None or place.board.id in boards]
    can = hub.line_statuses(place.board.id for place in places if place.info.lin is None)
    lin = hub.lin_statuses(place.board.id for place in places if place.info.lin is not None)
    found = []
    for place in places:
        at = place.board.id, place.line
        if at in can:
            found.append(Line(place, can[at], None))
        elif at in lin:
            found.append(Line(place, None, LinUse(lin[at].status, lin[at].control_holder)))
    return found


def can_lines(hub: Hub) -> list[Line]:
    """Return the CAN lines of the hub."""
    return [line for line in look(hub) if line.can is not None]


def lateness_of(lines: list[Line]) -> list[str]:
    """Return one sentence about lateness, or none: the buses of a hub share their time."""
    return sorted({line.lateness for line in lines} - {""})[-1:]


def by_board(lines: list[Line], boards: Collection[BoardInfo]) -> list[tuple[BoardInfo, list[Line]]]:
    """Return each board with its lines."""
    found: dict[int, list[Line]] = {board.id: [] for board in boards}
    for line in lines:
        found.get(line.place.board.id, []).append(line)
    return [(board, found[board.id]) for board in boards]


def find_can_line(hub: Hub, address: str) -> LinePlace:
    """The CAN line of exactly this address ("HW000001:0"); raises NoSuchBoard."""
    for place in every_line(hub, "CAN"):
        if place.address == address:
            return place
    raise NoSuchBoard(f"{address or 'no address'}: there is no such CAN line any more")
