"""One row per identifier: how often, how far apart, its latest data and which bytes of them changed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from canwire import EXTENDED, TYPE_MASK, EventKind, Frame, frame_of_record
from canwire.commands.live.listening import RECORD, Record

_FRESH_NS = 1_000_000_000  # so long a byte is marked after it changed


class Key(NamedTuple):
    """The key of a row: the line and the identifier. Rows are sorted by it."""

    line: str
    extended: bool
    id: int


class Row:
    """The frames of one identifier. Times are the bus's, in nanoseconds; gaps are None until there were two frames."""

    __slots__ = ("changed_ns", "count", "gap_ns", "key", "least_ns", "most_ns", "record")

    def __init__(self, key: Key, record: Record) -> None:
        self.key = key
        self.record = record
        self.count = 1
        self.gap_ns: int | None = None
        self.least_ns: int | None = None
        self.most_ns: int | None = None
        self.changed_ns: dict[int, int] = {}  # place of a byte: when it was last another than before

    @property
    def frame(self) -> Frame:
        """The latest frame."""
        return frame_of_record(RECORD.pack(*self.record))

    @property
    def changed(self) -> frozenset[int]:
        """Places of bytes that changed within a second of the latest frame."""
        now_ns = self.record[0]
        return frozenset(at for at, when_ns in self.changed_ns.items() if now_ns - when_ns < _FRESH_NS)

    def take(self, record: Record) -> None:
        """Count a further frame, and update gaps and changed bytes."""
        before = self.record
        gap_ns = max(0, record[0] - before[0])
        self.gap_ns = gap_ns
        if self.least_ns is None or gap_ns < self.least_ns:
            self.least_ns = gap_ns
        if self.most_ns is None or gap_ns > self.most_ns:
            self.most_ns = gap_ns
        if record[3] != before[3]:
            for at, (old, new) in enumerate(zip(before[3], record[3], strict=True)):
                if old != new:
                    self.changed_ns[at] = record[0]
        self.count += 1
        self.record = record

    def copy(self) -> Row:
        """Return a copy of this row, which later records do not change."""
        made = Row(self.key, self.record)
        made.count, made.gap_ns, made.least_ns, made.most_ns = (
            self.count,
            self.gap_ns,
            self.least_ns,
            self.most_ns,
        )
        made.changed_ns = dict(self.changed_ns)
        return made


class Table:
    """The rows of all frames given to `take`; `frames` and `errors` count these."""

    def __init__(self) -> None:
        self.frames = 0
        self.errors = 0
        self._rows: dict[Key, Row] = {}
        self._sorted: list[Row] | None = None

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def rows(self) -> list[Row]:
        """The rows in order: by line, 11-bit identifiers first."""
        if self._sorted is None:
            self._sorted = [self._rows[key] for key in sorted(self._rows)]
        return self._sorted

    def take(self, line: str, records: Sequence[Record]) -> None:
        """Add frames and events of one line, in their order."""
        rows = self._rows
        for record in records:
            info = record[2]
            if info & TYPE_MASK:
                self.errors += info & TYPE_MASK == EventKind.ERROR
                continue
            self.frames += 1
            key = Key(line, bool(info & EXTENDED), record[1])
            row = rows.get(key)
            if row is None:
                rows[key] = Row(key, record)
                self._sorted = None
            else:
                row.take(record)

    def clear(self) -> None:
        """Remove all rows and set the counts to 0."""
        self.frames = self.errors = 0
        self._rows.clear()
        self._sorted = None
