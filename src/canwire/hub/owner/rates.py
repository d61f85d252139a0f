"""Lines of one bus that could not work together on copper: told once."""

from __future__ import annotations

from collections.abc import Container, Hashable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from canwire.boards.board import Board, BoardLine
from canwire.boards.can.neighbours import neighbours
from canwire.boards.can.rates import RunningLine, bus_conflicts
from canwire.bus.can.bus import CanBus
from canwire.bus.can.node import Node
from canwire.bus.medium import delay_of
from canwire.values.timing.check import NodeTiming

if TYPE_CHECKING:
    from canwire.hub.owner.held.can import CanSlot


class Neighbours:
    """Who takes part in a hub's buses besides `controllers`, those of all its lines; each bus is checked one time."""

    def __init__(self, controllers: Container[Node]) -> None:
        self._controllers = controllers
        self._found: dict[str, tuple[NodeTiming, ...]] = {}

    def of(self, slot: CanSlot) -> tuple[NodeTiming, ...]:
        """Those of this line's bus; of one without a name there are none."""
        name, bus = slot.can.info.bus, slot.can.bus
        if not isinstance(bus, CanBus) or not name:
            return ()
        if name not in self._found:
            self._found[name] = tuple(neighbours(bus.nodes, self._controllers))
        return self._found[name]


class RateWatch:
    """What has been reported of each bus."""

    def __init__(self) -> None:
        self._controllers: set[Node] = set()  # of all CAN lines
        self._seen: dict[str, Hashable] = {}  # in which ways a bus's lines were set up
        self._told: dict[str, list[str]] = {}

    def plugged(self, board: Board) -> None:
        """Its lines are lines of the hub now."""
        self._controllers |= _controllers(board)

    def unplugged(self, board: Board) -> None:
        """They are not any more."""
        self._controllers -= _controllers(board)

    def others(self) -> Neighbours:
        """Who takes part in buses without being a line of the hub, as it is now."""
        return Neighbours(self._controllers)

    def news(self, bus: str, slots: Iterable[CanSlot]) -> list[str]:
        """What is to be said of this bus; `slots` are the hub's CAN lines. Nothing of what was said the last time."""
        running = [slot for slot in slots if slot.can.info.bus == bus and slot.can.running]
        others = self.others()
        ways = (
            len(running) > 1,
            frozenset(_way(slot) for slot in running),
            running and others.of(running[0]),
        )
        if ways == self._seen.get(bus) and not self._told.get(bus):
            return []  # a look at each line's status costs far more
        self._seen[bus] = ways
        conflicts = bus_conflicts(
            RunningLine(slot.name, bus, replace(slot.status(), neighbours=others.of(slot)))
            for slot in running
        )
        texts = [str(conflict) for conflict in conflicts]
        known, self._told[bus] = self._told.get(bus, []), texts
        return [text for text in texts if text not in known]


def _controllers(board: Board) -> set[Node]:
    return {slot.line.controller for slot in board.lines if isinstance(slot, BoardLine)}


def _way(slot: CanSlot) -> Hashable:
    mode = slot.can.mode
    if mode is None:
        return None
    timing = slot.can.chip_timing or mode.timing
    return timing, mode.data_timing, mode.options, slot.can.crystal.drift_ppm, delay_of(slot.can.bus)
