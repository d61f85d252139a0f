"""Warnings about lines of one bus that could not work together on a real bus, each given once."""

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
    """The nodes on a hub's buses other than `controllers`, those of the hub's lines; each bus is checked once."""

    def __init__(self, controllers: Container[Node]) -> None:
        self._controllers = controllers
        self._found: dict[str, tuple[NodeTiming, ...]] = {}

    def of(self, slot: CanSlot) -> tuple[NodeTiming, ...]:
        """The timings of such nodes on this line's bus; empty for a bus without a name."""
        name, bus = slot.can.info.bus, slot.can.bus
        if not isinstance(bus, CanBus) or not name:
            return ()
        if name not in self._found:
            self._found[name] = tuple(neighbours(bus.nodes, self._controllers))
        return self._found[name]


class RateWatch:
    """The warnings that were given about each bus."""

    def __init__(self) -> None:
        self._controllers: set[Node] = set()  # of all CAN lines
        self._seen: dict[str, Hashable] = {}  # in which ways a bus's lines were set up
        self._told: dict[str, list[str]] = {}

    def plugged(self, board: Board) -> None:
        """Add the lines of this board to those of the hub."""
        self._controllers |= _controllers(board)

    def unplugged(self, board: Board) -> None:
        """Remove the lines of this board."""
        self._controllers -= _controllers(board)

    def others(self) -> Neighbours:
        """The nodes that take part in buses at present and are no lines of the hub."""
        return Neighbours(self._controllers)

    def news(self, bus: str, slots: Iterable[CanSlot]) -> list[str]:
        """The warnings about this bus that are new since the last call; `slots` are the hub's CAN lines."""
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
