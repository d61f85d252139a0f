"""Schedule tables on the command line, as parse_lin_schedule reads them, or one of a description (LDF)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from canwire import BadValue, LinFrame, LinSchedule

_LONGEST_FRAME_BITS = 34 + 90, 1.4  # header and 9 bytes, and how much longer they may take: LIN 2.2A 2.3.2
_SLOT_STEP_NS = 5_000_000


def described(network: Any, name: str | None) -> tuple[LinSchedule, list[LinFrame]]:
    """A table of a description, and what its master publishes. Raises BadValue."""
    tables: dict[str, LinSchedule] = network.schedules
    if not tables or (name is not None and name not in tables):
        there = ", ".join(tables) or "none"
        why = network.unusable.get(name or "", "")
        told = f"schedule {name!r} cannot be run: {why}" if why else f"no schedule {name or ''!r}"
        raise BadValue(f"{network.path}: {told}; there are {there}")
    table = next(iter(tables.values())) if name is None else tables[name]
    return table, list(network.responses(network.master).values())


def with_delays(table: LinSchedule, bit_rate: int) -> LinSchedule:
    """The table with room for any frame, in steps of 5 ms, in slots that do not say how long they last."""
    bits, longer = _LONGEST_FRAME_BITS
    usual_ns = -(-round(bits * longer * 1e9 / bit_rate) // _SLOT_STEP_NS) * _SLOT_STEP_NS
    slots = (replace(slot, delay_ns=slot.delay_ns or usual_ns) for slot in table.slots)
    return LinSchedule(table.name, tuple(slots))
