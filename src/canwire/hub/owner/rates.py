"""Lines of one bus that run at different rates: told once."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from canwire.boards.can.modes import LineMode
from canwire.boards.can.rates import RunningLine, data_rate, rate_conflicts

if TYPE_CHECKING:
    from canwire.hub.owner.held.can import CanSlot


class RateWatch:
    """What has been told of each bus."""

    def __init__(self) -> None:
        self._told: dict[str, str] = {}

    def news(self, bus: str, slots: Iterable[CanSlot]) -> str:
        """What is to be said of this bus, whose CAN lines these are; "" if it was said already, or all agree."""
        running = [slot for slot in slots if slot.can.running]
        rates = {_rates(slot.can.mode) for slot in running}
        conflicts = []
        if len(rates) > 1:  # a look at each line's status costs far more
            conflicts = rate_conflicts(RunningLine(slot.name, bus, slot.status()) for slot in running)
        text = "".join(map(str, conflicts))
        known, self._told[bus] = self._told.get(bus, ""), text
        return "" if text == known else text


def _rates(mode: LineMode | None) -> tuple[int | None, int | None]:
    timing = None if mode is None else mode.timing
    return None if timing is None else timing.bit_rate, None if mode is None else data_rate(mode)
