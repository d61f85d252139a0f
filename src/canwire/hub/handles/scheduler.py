"""The right to a CAN line's cyclic transmit list."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from canwire.boards.can.modes import CyclicStatus
from canwire.hub.handles.lease import Lease
from canwire.hub.protocol import messages as m

if TYPE_CHECKING:
    from canwire.hub.handles.client import Client


class Scheduler(Lease):
    """The one lease on a line's cyclic transmit list (boards/can/scheduler.py)."""

    def __init__(self, hub: Client, handle: int, board: int, line: int) -> None:
        super().__init__(hub, handle, f"cyclic list of line {line}")
        self.board = board
        self.line = line

    def add(
        self,
        record: bytes,
        cycle: int,
        *,
        increment: int = 0,
        byte_index: int = 0,
        owner: Lease | None = None,
    ) -> int:
        """Index of the new object. `record` is its frame (values/record.py), request bits included; cycle in ticks.

        The channel `owner` of this hub connection receives the frames as its own, not as a sibling's.
        """
        channel = 0 if owner is None else owner.handle
        return int(self.ask(m.AddCyclic(self._handle, record, cycle, increment, byte_index, channel)).value)

    def replace(self, index: int, record: bytes) -> None:
        """Replace the frame; the ticks stay the same. Not for an entry whose frame counts up."""
        self.ask(m.ReplaceCyclic(self._handle, index, record))

    def remove(self, index: int) -> None:
        self.ask(m.RemoveCyclic(self._handle, index))

    def start(self, index: int, count: int = 0) -> None:
        """Send this entry `count` times, 0: until it is stopped."""
        self.ask(m.StartCyclic(self._handle, index, count))

    def start_in_turn(self, indices: Sequence[int], counts: Sequence[int], step: int) -> None:
        """Start the first entry in the next tick, the others each `step` ticks later; count 0: until it is stopped.

        Raises WrongState if the list does not run.
        """
        self.ask(m.StartInTurn(self._handle, tuple(indices), tuple(counts), step))

    def stop(self, index: int) -> None:
        self.ask(m.StopCyclic(self._handle, index))

    def resume(self) -> None:
        self.ask(m.RunScheduler(self._handle, True))

    def suspend(self) -> None:
        self.ask(m.RunScheduler(self._handle, False))

    def reset(self) -> None:
        self.ask(m.ResetScheduler(self._handle))

    def status(self) -> CyclicStatus:
        status: CyclicStatus = self.ask(m.GetSchedulerStatus(self._handle)).status
        return status
