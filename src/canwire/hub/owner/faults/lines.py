"""The lines of one bus by their names, for faults of a single line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from canwire.boards.board import Board
from canwire.boards.can.connector import CanLine
from canwire.boards.lin.line import LinLine
from canwire.errors import NoSuchBoard
from canwire.hub.owner.held.can import CanSlot
from canwire.hub.owner.held.lin import LinSlot


class LinesOf:
    """The lines that belong to one bus, including those that a fault has disconnected."""

    def __init__(
        self, bus: str, boards: Mapping[int, Board], slots: Mapping[tuple[int, int], CanSlot | LinSlot]
    ) -> None:
        self._bus = bus
        self._boards = boards
        self._slots = slots

    def all(self) -> Iterator[CanSlot | LinSlot]:
        """All lines, in the order of plugging."""
        for number, board in self._boards.items():
            for index, line in enumerate(board.lines):
                if line.info.bus == self._bus:
                    yield self._slots[number, index]

    def can(self, name: str) -> CanLine:
        """Raises NoSuchBoard with the lines there are."""
        for slot in self.all():
            if slot.name == name and isinstance(slot, CanSlot):
                return slot.can
        raise self._none(name)

    def lin(self, name: str) -> LinLine:
        """Raises NoSuchBoard with the lines there are."""
        for slot in self.all():
            if slot.name == name and isinstance(slot, LinSlot):
                return slot.lin
        raise self._none(name)

    def running(self) -> CanLine | None:
        """The first CAN line that runs; its bit rate is used for the bus."""
        lines = (slot.can for slot in self.all() if isinstance(slot, CanSlot))
        return next((can for can in lines if can.running and can.mode is not None), None)

    def _none(self, name: str) -> NoSuchBoard:
        there = ", ".join(slot.name for slot in self.all()) or "none"
        return NoSuchBoard(f"no line {name!r} on {self._bus}; there are {there}")
