"""Lines of a hub by name.

HW000001:0        line 0 of the board with that hardware id
usb-to-can-fd:1   line 1 of the first board of that kind
can0, lin0        every line on that bus
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

from canwire.boards.description import BoardInfo, LineInfo, board_named
from canwire.errors import NoSuchBoard
from canwire.values.checks import instance
from canwire.values.mistakes.calls import answers_wrong_calls

if TYPE_CHECKING:
    from canwire.boards.can.modes import LineStatus
    from canwire.hub.handles.hub import Hub

_ADDRESS = re.compile(r"(.+):(\d{1,3})", re.DOTALL)


class LinePlace(NamedTuple):
    """A line of a board: `line` counts from 0."""

    board: BoardInfo
    line: int

    @property
    def info(self) -> LineInfo:
        return self.board.lines[self.line]

    @property
    def address(self) -> str:
        """The name of this line alone: "HW000001:0"."""
        return f"{self.board.hardware_id}:{self.line}"

    def status(self, hub: Hub) -> LineStatus:
        """The present status of a CAN line; raises Unplugged, HubLost."""
        return hub.line_status(self.board.id, self.line)


def every_line(hub: Hub, bus_type: str | None = None) -> list[LinePlace]:
    """All lines of the hub, or only its "CAN" or "LIN" lines, in the order of the boards."""
    places = [LinePlace(board, line) for board in hub.boards() for line in range(len(board.lines))]
    return [place for place in places if bus_type in (None, place.info.bus_type)]


def lines_now(hub: Hub, places: Iterable[LinePlace]) -> list[tuple[LinePlace, LineStatus]]:
    """The status of these CAN lines, without lines of boards that were unplugged meanwhile. Raises HubLost."""
    asked = list(places)
    found = hub.line_statuses(place.board.id for place in asked)
    there = ((place, found.get((place.board.id, place.line))) for place in asked)
    return [(place, status) for place, status in there if status is not None]


def unused_lines(hub: Hub, places: Iterable[LinePlace]) -> Iterator[LinePlace]:
    """The ones of these CAN lines that do not run and where no program has a channel or the control. Raises HubLost."""
    return (place for place, status in lines_now(hub, places) if status.unused)


@answers_wrong_calls
def find_lines(
    hub: Hub, name: str, bus_type: str | None = None, *, among: Sequence[LinePlace] | None = None
) -> list[LinePlace]:
    """The lines that a name means: all lines on the bus of that name, else the one line with that address.

    `bus_type` "CAN" or "LIN" leaves out the other kind. The list has at least one line; NoSuchBoard, with the names of
    all lines, is raised otherwise. `among` are the lines that `every_line` has already found.
    """
    instance("name", name, str)
    lines = every_line(hub) if among is None else among
    places = [place for place in lines if bus_type in (None, place.info.bus_type)]
    on_bus = [place for place in places if name and place.info.bus == name]
    return on_bus or [_by_address(lines, name, places, bus_type)]


def _by_address(
    lines: Sequence[LinePlace], name: str, places: list[LinePlace], bus_type: str | None
) -> LinePlace:
    if found := _ADDRESS.fullmatch(name):
        boards = {place.board.id: place.board for place in lines}
        board, line = board_named(boards.values(), found[1]), int(found[2])
        if line >= len(board.lines):
            raise NoSuchBoard(f"{name}: {board.hardware_id} has the lines 0 to {len(board.lines) - 1}")
        if bus_type in (None, board.lines[line].bus_type):
            return LinePlace(board, line)
    there = ", ".join(f"{place.address} (on {place.info.bus or 'no bus'})" for place in places) or "none"
    what = "line" if bus_type is None else f"{bus_type} line"
    near = _nearest(name, places)
    raise NoSuchBoard(
        f"no {what} or bus {name!r}; there are {there}{f'; did you mean {near}?' if near else ''}"
    )


def _nearest(name: str, places: list[LinePlace]) -> str:
    """The name that was meant perhaps: "" where none looks like it."""
    from difflib import get_close_matches

    names = {known.lower(): known for place in places for known in (place.info.bus, place.address) if known}
    return next((names[found] for found in get_close_matches(name.lower(), names, 1)), "")
