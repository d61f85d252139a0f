"""The present state of a hub's lines, and the programs that use them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

from canwire import (
    BoardInfo,
    LinErrorKind,
    LineStatus,
    LinLineStatus,
    RateConflict,
    RunningLine,
    TimingConflict,
    bus_conflicts,
)

if TYPE_CHECKING:
    from canwire import Hub


class LinUse(NamedTuple):
    """The status of a LIN line, and the programs that use it."""

    status: LinLineStatus
    control_holder: str
    exclusive: bool


Use = LineStatus | LinUse
Found = tuple[BoardInfo, list[Use]]


def conflicts_among(found: list[Found]) -> list[RateConflict | TimingConflict]:
    """Bit rates and timings that would not work on a real bus."""
    return bus_conflicts(
        RunningLine(f"{board.hardware_id}:{index}", line.bus, status)
        for board, states in found
        for index, (line, status) in enumerate(zip(board.lines, states, strict=True))
        if isinstance(status, LineStatus)
    )


def lateness_among(found: list[Found]) -> set[str]:
    """The message about buses that cannot keep up with the clock; empty if all do."""
    every = [use.status if isinstance(use, LinUse) else use for _, uses in found for use in uses]
    said = {status.lateness for status in every}
    return set(sorted(said - {""})[-1:])  # one sentence: the buses of a hub share their time


def boards_of(hub: Hub) -> Iterator[Found]:
    """Each board with the status of its lines; boards that are unplugged meanwhile are left out."""
    boards = hub.boards()
    found: dict[tuple[int, int], Use] = {**hub.line_statuses(_with(boards, "CAN"))}
    for at, state in hub.lin_statuses(_with(boards, "LIN")).items():
        found[at] = LinUse(state.status, state.control_holder, state.exclusive)
    for board in boards:
        places = [(board.id, line) for line in range(len(board.lines))]
        if all(place in found for place in places):
            yield board, [found[place] for place in places]


def _with(boards: Iterable[BoardInfo], bus_type: str) -> list[int]:
    """Return the ids of the boards that have lines of this bus type."""
    return [board.id for board in boards if any(line.bus_type == bus_type for line in board.lines)]


def errors_by_kind(status: LinLineStatus) -> dict[str, int]:
    """The number of errors of each LinErrorKind, by name."""
    return {kind.name: count for kind, count in zip(LinErrorKind, status.errors, strict=True) if kind}
