"""Answers to viewers as bytes: a head in JSON, rows, and by identifier an extra for each of them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy

from canwire import BadFrame, Frame, LinFrame, frame_of_record
from canwire.web.trace.store.kinds import Test
from canwire.web.trace.store.lin import is_lin, lin_message

if TYPE_CHECKING:
    from canwire.web.databases.loaded import Databases
    from canwire.web.trace.look import Look
    from canwire.web.trace.source import Source
    from canwire.web.trace.store.identifiers import Page
    from canwire.web.trace.store.selection import Selection
    from canwire.web.words import Words

EXTRA = numpy.dtype(
    [("count", "<f8"), ("cycle_ms", "<f4"), ("least_ms", "<f4"), ("most_ms", "<f4"), ("mean_ms", "<f4"),
     ("silent_s", "<f4"), ("none", "<f4"), ("changed", "u1", 64)]
)  # fmt: skip
"""By identifier: `changed` is how many hundredths of a second ago each byte changed, 255 for longer or never."""
_KEPT_TEXTS = 4096


class Shown(NamedTuple):
    """The present view of a viewer. `fault` is the invalid part of its filter, `bad_rules` are its invalid rules."""

    look: Look
    source: Source
    selection: Selection
    fault: str
    bad_rules: list[int]


class Answers:
    """Makes the answers to one viewer. `rules` are filters with their colours."""

    def __init__(self, databases: Databases, word: Words) -> None:
        self._databases = databases
        self._word = word
        self._texts: dict[tuple[int, int, bytes], list[tuple[str, str]]] = {}
        self._told: object = None
        self.rules: list[tuple[Test, int]] | None = None

    def by_time(self, shown: Shown, at: int, count: int, found: int | None) -> bytes:
        """Return the rows from place `at` on; `found` is the place of the row that was searched for, -1 without one."""
        rows = shown.selection.rows(at, count)
        head = self._head(shown)
        head |= {"at": at, "rows": len(rows), "count": shown.selection.count, "byFrame": False}
        if found is not None:
            head["found"] = found
        return _packed(head, self._coloured(rows).tobytes())

    def by_frame(self, shown: Shown, page: Page, left_out: int) -> bytes:
        """Return rows of the table by identifier, with their signals."""
        now_ns = shown.source.now_ns()
        extra = numpy.zeros(len(page.rows), EXTRA)
        extra["count"] = page.extra["count"]
        for name in ("cycle", "least", "most", "mean"):
            extra[f"{name}_ms"] = page.extra[name] / 1e6
        extra["silent_s"] = (now_ns - page.rows["record"]["time_ns"].astype(float)) / 1e9
        changed = page.extra["changed"].astype(float)
        ages = numpy.where(changed > 0, (now_ns - changed) / 1e7, 255)
        extra["changed"] = numpy.clip(ages, 0, 255)
        head = self._head(shown)
        head |= {"at": page.at, "rows": len(page.rows), "count": page.length, "leftOut": left_out}
        head["byFrame"] = True
        head["signals"] = [self._signals(shown.source, row) for row in page.rows]
        return _packed(head, self._coloured(page.rows).tobytes() + extra.tobytes())

    def _head(self, shown: Shown) -> dict[str, Any]:
        source, selection, history = shown.source, shown.selection, shown.source.history
        lines = source.lines(shown.look.lines)
        head = {
            "look": shown.look.number,
            "fault": shown.fault,
            "badRules": shown.bad_rules,
            "gone": selection.gone,
            "cursor": selection.cursor,
            "end": selection.end,
            "total": history.total,
            "first": history.first,
            "late": history.late,
            "lost": sum(line.lost for line in lines),
            "trouble": self._word.trouble(source.trouble),
            "databases": self._databases.version,
        }
        told = lines, history.eras
        if told != self._told:
            self._told = told
            head["lines"] = [
                {**line._asdict(), "trouble": self._word.trouble(line.trouble)} for line in lines
            ]
            head["eras"] = history.eras[-16:]
        return head

    def _coloured(self, rows: numpy.ndarray) -> numpy.ndarray:
        rows = rows.copy()
        for test, colour in reversed(self.rules or []):  # the first one that fits wins
            rows["colour"][test(rows)] = colour
        return rows

    def _signals(self, source: Source, row: numpy.ndarray) -> list[tuple[str, str]]:
        record, line = row["record"].tobytes(), int(row["line"])
        key = self._databases.version, line, record[8:]
        if key not in self._texts:
            if len(self._texts) >= _KEPT_TEXTS:
                self._texts.clear()
            frame = frame_of(record)
            database = self._databases.of(source.bus_of(line))
            found = [] if frame is None else database.signals(frame)
            self._texts[key] = [(one.name, f"{one.value} {one.unit}".strip()) for one in found]
        return self._texts[key]


def frame_of(record: bytes) -> Frame | LinFrame | None:
    """Return a row's frame; None for a row that is no frame."""
    try:
        if record[12] == 0:
            return frame_of_record(record)
        message = lin_message(record) if is_lin(record[12]) else None
    except (BadFrame, ValueError):
        return None
    return message if isinstance(message, LinFrame) else None


def _packed(head: dict[str, Any], rows: bytes) -> bytes:
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 8)  # rows begin at whole words
    return len(text).to_bytes(4, "little") + b"\0\0\0\0" + text + rows
