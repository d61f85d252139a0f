"""Schedule tables on the command line: `10`, `11:4@10ms`, `12#0102@20ms`, or one of a description (LDF)."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

from canwire import BadValue, LinFrame, LinSchedule, LinSlot, parse_lin_frame

_UNITS_NS = {"ms": 1_000_000, "us": 1_000, "s": 1_000_000_000}
_SLOT = re.compile(
    r"(?P<frame>(?P<id>[0-9A-Fa-f]{2})(?::(?P<length>[1-8])|#\S*?)?)"
    r"(?:@(?P<delay>\d{1,7}(?:\.\d{1,6})?)(?P<unit>ms|us|s))?",
    re.ASCII,
)
_LONGEST_FRAME_BITS = 34 + 90, 1.4  # header and 9 bytes, and how much longer they may take: LIN 2.2A 2.3.2
_SLOT_STEP_NS = 5_000_000


def parsed(slots: list[str]) -> tuple[LinSchedule, list[LinFrame]]:
    """The table that slots make, and the frames to answer with; raises BadValue, BadText.

    A slot is an identifier, and behind it how many bytes to ask for or the data to answer with; then the time to the
    next slot (0 where it is left out).
    """
    made, frames = [], []
    for text in slots:
        found = _SLOT.fullmatch(text)
        if found is None:
            raise BadValue(
                f"slot {text!r}: like 10, 11:4@10ms (bytes asked for, time to the next), 12#0102@20ms"
            )
        if "#" in found["frame"]:
            frames.append(parse_lin_frame(found["frame"]))
            if frames[-1].header_only:
                raise BadValue(f"slot {text!r}: data behind #; write {found['id']}:4 to ask for 4 bytes")
        delay_ns = round(float(found["delay"]) * _UNITS_NS[found["unit"]]) if found["delay"] else 0
        try:
            id, length = int(found["id"], 16), int(found["length"] or 0)
            made.append(LinSlot.frame(id, delay_ns=delay_ns, length=length))
        except BadValue as error:
            raise BadValue(f"slot {text!r}: {error}") from None
    return LinSchedule.of(made, "canwire"), frames


def described(network: Any, name: str | None) -> tuple[LinSchedule, list[LinFrame]]:
    """A table of a description, and what its master publishes. Raises BadValue."""
    tables: dict[str, LinSchedule] = network.schedules
    if not tables or (name is not None and name not in tables):
        there = ", ".join(tables) or "none"
        raise BadValue(f"{network.path}: no schedule {name or ''!r}; there are {there}")
    table = next(iter(tables.values())) if name is None else tables[name]
    return table, list(network.responses(network.master).values())


def with_delays(table: LinSchedule, bit_rate: int) -> LinSchedule:
    """The table with room for any frame, in steps of 5 ms, in slots that do not say how long they last."""
    bits, longer = _LONGEST_FRAME_BITS
    usual_ns = -(-round(bits * longer * 1e9 / bit_rate) // _SLOT_STEP_NS) * _SLOT_STEP_NS
    slots = (replace(slot, delay_ns=slot.delay_ns or usual_ns) for slot in table.slots)
    return LinSchedule(table.name, tuple(slots))
