"""Merges rows of all lines in the order of their time stamps; each row is numbered one sweep over the queues later.

The hub puts records into its queues in the order of time, but a sweep reads one queue after the other. A row is
therefore held until a sweep that began after a row with a later stamp had been seen; that sweep reads all older rows.
A row that arrives even later is put at the end and flagged.
"""

from __future__ import annotations

import numpy

from canwire.web.trace.store.history import History
from canwire.web.trace.store.rows import LATE, mark_row, row_dtype, rows_of


class Merger:
    """Puts rows of several lines in order before a history gets them; it runs in the writer's thread."""

    def __init__(self, history: History) -> None:
        self._history = history
        self._held: list[numpy.ndarray] = []
        self._newest_ns = 0  # of all rows that were taken
        self._sure_ns = 0  # of those before the present sweep
        self._numbered_ns = 0

    def take(self, records: numpy.ndarray, line: int) -> None:
        """Add records of one line, in the order of its queue."""
        self._newest_ns = max(self._newest_ns, int(records["time_ns"].max()))
        self._held.append(rows_of(records, line))

    def mark(self, kind: int, line: int, count: int) -> None:
        """Add a mark of missing data, after all records added so far."""
        self._held.append(mark_row(kind, line, count, self._newest_ns))

    def release(self) -> None:
        """At the end of a sweep, number the rows before which no other row can come."""
        if self._held:
            rows = numpy.concatenate(self._held)
            sure = rows["record"]["time_ns"] <= self._sure_ns
            self._held = [rows[~sure]] if not sure.all() else []
            self._number(rows[sure])
        self._sure_ns = self._newest_ns

    def restart(self, epoch_ns: int) -> None:
        """For another hub, number all held rows and restart with the time of that hub."""
        self._number(numpy.concatenate([numpy.zeros(0, row_dtype()), *self._held]))
        self._held = []
        self._newest_ns = self._sure_ns = self._numbered_ns = 0
        self._history.begin_era(epoch_ns)

    def _number(self, rows: numpy.ndarray) -> None:
        if not len(rows):
            return
        rows = rows[numpy.argsort(rows["record"]["time_ns"], kind="stable")]
        stamps = rows["record"]["time_ns"]
        rows["flags"] |= numpy.where(stamps < self._numbered_ns, LATE, 0).astype(numpy.uint8)
        self._numbered_ns = max(self._numbered_ns, int(stamps[-1]))
        self._history.append(rows)
