"""Schedule tables as text: `10`, `11:4@10ms`, `12#0102@20ms`."""

from __future__ import annotations

import re
from collections.abc import Iterable

from canwire.errors import BadValue
from canwire.values.checks import instance
from canwire.values.lin.frame import LinFrame
from canwire.values.lin.schedule import LinSchedule, LinSlot
from canwire.values.lin.text import parse_lin_frame

_UNITS_NS = {"ms": 1_000_000, "us": 1_000, "s": 1_000_000_000}
_SLOT = re.compile(
    r"(?P<frame>(?P<id>[0-9A-Fa-f]{2})(?::(?P<length>[1-8])|#\S*?)?)"
    r"(?:@(?P<delay>\d{1,7}(?:\.\d{1,6})?)(?P<unit>ms|us|s))?",
    re.ASCII,
)


def parse_lin_schedule(slots: Iterable[str], name: str = "canwire") -> tuple[LinSchedule, list[LinFrame]]:
    """The table that slots make, and the frames to answer with; raises BadValue, BadText.

    A slot is an identifier, after it how many bytes to ask for or the data to answer with; then the time to the
    next slot (0 where it is left out).
    """
    instance("name", name, str)
    made, frames = [], []
    for text in slots:
        instance("slot", text, str)
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
    return LinSchedule.of(made, name), frames
