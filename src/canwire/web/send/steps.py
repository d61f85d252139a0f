"""A sequence: frames one after the other, with pauses between them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

from canwire import BadFrame, BadSignals, BadText, BadValue, Frame, LinFrame, parse_frame, parse_lin_frame

if TYPE_CHECKING:
    from canwire.web.database import Database

MOST_STEPS = 1000
_PAUSE = re.compile(r"(\d{1,7}(?:[.,]\d{1,3})?)\s*(?:ms)?")
_MESSAGE = re.compile(r"([A-Za-z_]\w*)((?:\s+\w+\s*=\s*\S+)*)")


class Step(NamedTuple):
    """One frame, and the minimum time until the next one."""

    frame: Frame | LinFrame
    pause_ms: float


def parsed(text: str, database: Database, *, lin: bool) -> tuple[Step, ...]:
    """Parse steps, each in a line or between semicolons: `123#1122`, `EngineData Speed=1000`, or a pause, `10 ms`.

    Raises BadValue with the invalid part.
    """
    steps: list[Step] = []
    for part in (one.strip() for one in re.split(r"[;\n]", text)):
        pause = _PAUSE.fullmatch(part)
        if not part:
            continue
        if pause and steps:
            ms = float(pause[1].replace(",", "."))
            steps[-1] = Step(steps[-1].frame, steps[-1].pause_ms + ms)
        else:
            steps.append(Step(_frame(part, database, lin), 0.0))
    if not 0 < len(steps) <= MOST_STEPS:
        raise BadValue("")
    return tuple(steps)


def _frame(part: str, database: Database, lin: bool) -> Frame | LinFrame:
    try:
        if "#" in part:
            return parse_lin_frame(part) if lin else parse_frame(part)
        found = _MESSAGE.fullmatch(part)
        if found is None:
            raise BadValue(part)
        values = dict(re.findall(r"(\w+)\s*=\s*(\S+)", found[2]))
        frame = database.encode(found[1], values)
    except (BadText, BadFrame, BadSignals) as error:
        raise BadValue(f"{part}: {error}") from None
    if isinstance(frame, LinFrame) != lin:
        raise BadValue(part)
    return frame
