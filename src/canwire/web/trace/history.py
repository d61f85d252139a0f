"""The last rows of all watched lines, in the order in which they came; every viewer reads at its own pace.

A row has 88 bytes: a record of 80 (values/record.py), the line's index, and the low 32 bits of its number.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy

from canwire import record_dtype

if TYPE_CHECKING:
    from collections.abc import Collection

ROW_BYTES = 88
GAP, LOST = (
    0xF0,
    0xF1,
)  # kinds of rows that are no record of the hub's: it was away; so many records were lost
_NO_ID = 0xFFFFFFFF


@cache
def row_dtype() -> numpy.dtype[numpy.void]:
    """record, line, number."""
    return numpy.dtype(
        {
            "names": ["record", "line", "number"],
            "formats": [record_dtype(), "<u2", "<u4"],
            "offsets": [0, 80, 84],
            "itemsize": ROW_BYTES,
        }
    )


class Passage(NamedTuple):
    """Rows from `cursor` on. `skipped` rows before them are gone; the next passage begins at `after`."""

    rows: numpy.ndarray
    skipped: int
    after: int


class History:
    """A ring of rows. Any thread may write and read; `total` counts every row there ever was."""

    def __init__(self, capacity: int = 1 << 17) -> None:
        self._rows = numpy.zeros(capacity, row_dtype())
        self._capacity = capacity
        self._lock = threading.Lock()
        self._listeners: list[Callable[[], None]] = []
        self.total = 0

    def listen(self, grown: Callable[[], None]) -> None:
        """Call this, in the writer's thread, after every write."""
        with self._lock:
            self._listeners.append(grown)

    def unlisten(self, grown: Callable[[], None]) -> None:
        with self._lock:
            self._listeners.remove(grown)

    def append(self, records: numpy.ndarray, line: int) -> None:
        """Records of one line, oldest first."""
        rows = numpy.zeros(len(records), row_dtype())
        rows["record"] = records
        rows["line"] = line
        self._append(rows)

    def mark(self, kind: int, line: int, count: int, time_ns: int = 0) -> None:
        """A row that says what is missing: GAP with milliseconds, LOST with records."""
        row = numpy.zeros(1, row_dtype())
        row["record"]["time_ns"] = time_ns
        row["record"]["id"] = _NO_ID
        row["record"]["info"] = kind
        row["record"]["data"][0, :8] = numpy.frombuffer(count.to_bytes(8, "little"), numpy.uint8)
        row["line"] = line
        self._append(row)

    def since(self, cursor: int, limit: int, lines: Collection[int] | None = None) -> Passage:
        """Up to `limit` rows from number `cursor` on, of these lines alone (None: all)."""
        with self._lock:
            begin = max(cursor, self.total - self._capacity)
            end = min(begin + limit, self.total)
            places = numpy.arange(begin, end) % self._capacity
            rows = self._rows[places]
        if lines is not None:
            rows = rows[numpy.isin(rows["line"], list(lines))]
        return Passage(rows, begin - cursor, end)

    def _append(self, rows: numpy.ndarray) -> None:
        with self._lock:
            rows["number"] = numpy.arange(self.total, self.total + len(rows)) & 0xFFFFFFFF
            kept = rows[-self._capacity :]
            first = self.total + len(rows) - len(kept)
            self._rows[numpy.arange(first, first + len(kept)) % self._capacity] = kept
            self.total += len(rows)
            listeners = list(self._listeners)
        for grown in listeners:
            grown()
