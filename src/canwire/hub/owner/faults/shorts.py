"""Shorted wires: they stay shorted while any fault shorts them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from canwire.bus.can.bus import CanBus
from canwire.bus.lin.bit_level import FREE
from canwire.bus.lin.bus import LinBus
from canwire.errors import BadValue, NoSuchBoard
from canwire.hub.owner.held.can import CanSlot
from canwire.hub.owner.held.line import LineSlot

_LEVELS = {"ground": 0, "supply": 1}


class Shorts:
    """The faults that short each bus; the short ends with the last of them."""

    def __init__(
        self, buses: Mapping[str, CanBus | LinBus], slots: Mapping[tuple[int, int], LineSlot]
    ) -> None:
        self._buses = buses
        self._slots = slots
        self._by: dict[str, dict[object, int]] = {}

    def put(self, name: str, by: object, to: str = "ground") -> None:
        """Short a bus, a LIN bus `to` "ground" or the "supply". Raises NoSuchBoard, BadValue."""
        if to not in _LEVELS:
            raise BadValue(f"to {to!r}: 'ground' or 'supply'")
        if to != "ground" and isinstance(self._buses.get(name), CanBus):
            raise BadValue(f"to {to!r}: a CAN bus's two wires are shorted to each other")
        self._by.setdefault(name, {})[by] = _LEVELS[to]
        self._show(name)

    def take(self, name: str, by: object) -> None:
        """End the short of this fault; raises NoSuchBoard."""
        self._by.get(name, {}).pop(by, None)
        self._show(name)

    def _show(self, name: str) -> None:
        bus, levels = self._buses.get(name), list(self._by.get(name, {}).values())
        if isinstance(bus, CanBus):
            if bool(levels) != bool(bus.bits.shorted):
                bus.short(bool(levels))
                _tell(self._slots.values(), bus)
        elif isinstance(bus, LinBus):
            bus.short(levels[-1] if levels else FREE)
        else:
            raise NoSuchBoard(f"no bus {name!r}; there are {', '.join(self._buses) or 'none'}")


def _tell(slots: Iterable[LineSlot], bus: CanBus) -> None:
    """Report the short to transceivers that can detect it."""
    for slot in slots:
        if isinstance(slot, CanSlot) and slot.can.bus is bus:
            slot.can.coupling_changed()
