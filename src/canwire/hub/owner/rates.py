"""Lines of one bus that could not work together on copper: told once."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING

from canwire.boards.can.rates import RunningLine, bus_conflicts
from canwire.bus.medium import delay_of

if TYPE_CHECKING:
    from canwire.hub.owner.held.can import CanSlot


class RateWatch:
    """What has been told of each bus."""

    def __init__(self) -> None:
        self._seen: dict[str, Hashable] = {}  # in which ways its lines were set up
        self._told: dict[str, list[str]] = {}

    def news(self, bus: str, slots: Iterable[CanSlot]) -> list[str]:
        """What is to be said of this bus, whose CAN lines these are; nothing of what was said the last time."""
        running = [slot for slot in slots if slot.can.running]
        ways = (len(running) > 1, frozenset(_way(slot) for slot in running))
        if ways == self._seen.get(bus) and not self._told.get(bus):
            return []  # a look at each line's status costs far more
        self._seen[bus] = ways
        conflicts = bus_conflicts(RunningLine(slot.name, bus, slot.status()) for slot in running)
        texts = [str(conflict) for conflict in conflicts]
        known, self._told[bus] = self._told.get(bus, []), texts
        return [text for text in texts if text not in known]


def _way(slot: CanSlot) -> Hashable:
    mode = slot.can.mode
    if mode is None:
        return None
    return mode.timing, mode.data_timing, mode.options, slot.can.crystal.drift_ppm, delay_of(slot.can.bus)
