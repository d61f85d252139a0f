"""Rows of the history as lines of a log file, in candump's form."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from canwire import (
    BadFrame,
    BusEvent,
    EventKind,
    Frame,
    LinEvent,
    LinFrame,
    LinLogLine,
    LogLine,
    format_lin_log_line,
    format_log_line,
    frame_of_record,
)
from canwire.web.trace.history import GAP, LOST, History
from canwire.web.trace.lin import is_lin, lin_message

if TYPE_CHECKING:
    import numpy

_AT_ONCE = 4096
_SELF_RECEIVED = 1 << 21  # of the info word: sent by the line itself


def log_lines(history: History, names: Mapping[int, str], epoch_ns: int, *, errors: bool) -> Iterator[str]:
    """Text of up to 4,096 lines at a time: what the history has of the lines in `names`, when this is called."""
    cursor, end = 0, history.total
    while cursor < end:
        rows, _, cursor = history.since(cursor, min(_AT_ONCE, end - cursor), names)
        yield "".join(f"{line}\n" for line in format_rows(rows, names, epoch_ns, errors=errors))


def format_rows(rows: numpy.ndarray, names: Mapping[int, str], epoch_ns: int, *, errors: bool) -> list[str]:
    """Frames, with `errors` error frames and changes of state too; `names` are the interfaces by line number."""
    found = []
    for row in rows:
        content = _content(row["record"].tobytes(), errors)
        if content is not None:
            stamp_ns, name = epoch_ns + content.timestamp_ns, names[int(row["line"])]
            if isinstance(content, LinFrame | LinEvent):
                found.append(format_lin_log_line(LinLogLine(stamp_ns, name, content, _direction(content))))
            else:
                direction = "T" if int(row["record"]["info"]) & _SELF_RECEIVED else "R"
                found.append(format_log_line(LogLine(stamp_ns, name, content, direction)))
    return found


def _direction(content: LinFrame | LinEvent) -> str | None:
    if isinstance(content, LinEvent):
        return None
    return "T" if content.sent else "R"


def _content(record: bytes, errors: bool) -> Frame | BusEvent | LinFrame | LinEvent | None:
    kind = record[12]
    if is_lin(kind):
        message = lin_message(record)
        return message if errors or isinstance(message, LinFrame) else None
    if kind in (GAP, LOST) or (kind and not (errors and kind in (EventKind.ERROR, EventKind.STATE))):
        return None
    try:
        return BusEvent.from_record(record) if kind else frame_of_record(record)
    except BadFrame:
        return None
