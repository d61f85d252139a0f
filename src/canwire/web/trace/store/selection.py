"""The rows of a history that a viewer's filter selects: their numbers are found once, and then only for new rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy

from canwire.web.trace.store.history import CHUNK, History
from canwire.web.trace.store.kinds import Test, is_mark
from canwire.web.trace.store.rows import EVERY_LINE

if TYPE_CHECKING:
    from collections.abc import Collection

    from numpy.typing import NDArray

_LAST = 0xFFFFFFFF
STEP = 16 * CHUNK  # rows that are looked at before others have their turn


class Selection:
    """Rows of these lines (numbers; None: all) that pass `test` (None: all). Marks of these lines are always included.

    Places count from 0 and never change, so that a list that is scrolled back keeps its rows.
    """

    def __init__(
        self, history: History, lines: Collection[int] | None, test: Test | None, since: int = 0
    ) -> None:
        self._history = history
        self._lines: NDArray[numpy.bool_] | None = None  # by number, whether it is one of them
        if lines is not None:
            self._lines = numpy.zeros(EVERY_LINE + 1, bool)
            self._lines[[*lines, EVERY_LINE]] = True
        self._test = test
        self._until: int | None = None
        self._numbers = numpy.zeros(1024, numpy.uint32)
        self.count = 0
        self.cursor = max(since, history.first)

    def stop(self, until: int | None) -> None:
        """Show only rows before this number; None: no limit."""
        self._until = until
        if until is not None and self.cursor > until:
            self.count, self.cursor = self.place_of(until), until

    @property
    def end(self) -> int:
        """The number up to which it could be extended now."""
        total, until = self._history.total, self._until
        return total if until is None else min(total, until)

    @property
    def gone(self) -> int:
        """Number of its rows that the history has removed."""
        return self.place_of(self._history.first)

    def extend(self) -> bool:
        """Check up to STEP more rows; returns whether there are still more."""
        end = self.end
        stop = min(self.cursor + STEP, end)
        begin = max(self.cursor, self._history.first)
        for rows in self._history.blocks(begin, stop):
            self._add(rows)
        self.cursor = max(stop, self.cursor)
        return self.cursor < end

    def rows(self, place: int, count: int) -> numpy.ndarray:
        """Return up to `count` rows from a place on; removed rows are left out."""
        place = max(place, 0)
        return self._history.pick(self.numbers(place, count))

    def numbers(self, place: int, count: int) -> NDArray[numpy.int64]:
        """Return the numbers of up to `count` rows from a place on."""
        return self._numbers[place : min(place + count, self.count)].astype(numpy.int64)

    def place_of(self, number: int) -> int:
        """Return the place of the first row whose number is not less than `number`."""
        if number > _LAST:
            return self.count
        # of the same type: else numpy would make all of them another one first
        return int(numpy.searchsorted(self._numbers[: self.count], numpy.uint32(max(number, 0))))

    def place_at(self, time_ns: int) -> int:
        """Return the place of the first row whose time is not less; times of different hubs are not distinguished."""
        low, high = self.gone, self.count
        while low < high:
            middle = (low + high) // 2
            rows = self.rows(middle, 1)
            if len(rows) and int(rows["record"]["time_ns"][0]) >= time_ns:
                high = middle
            else:
                low = middle + 1
        return min(low, self.count - 1)

    def find(self, test: Test, place: int, step: int) -> int | None:
        """Return the nearest place after (step 1) or before (step -1) this one whose row passes; wraps around at the
        end."""
        forwards = [(place + 1, self.count), (self.gone, place)]
        backwards = [(self.gone, place), (place + 1, self.count)]
        for begin, end in forwards if step > 0 else backwards:
            found = self._find_between(test, max(begin, self.gone), min(end, self.count), step)
            if found is not None:
                return found
        return None

    def _find_between(self, test: Test, begin: int, end: int, step: int) -> int | None:
        starts = range(begin, end, CHUNK)
        for start in starts if step > 0 else reversed(starts):
            count = min(CHUNK, end - start)
            rows = self.rows(start, count)
            missing = count - len(rows)
            passed = numpy.flatnonzero(test(rows))
            if len(passed):
                return start + missing + int(passed[0 if step > 0 else -1])
        return None

    def _add(self, rows: numpy.ndarray) -> None:
        if not len(rows):
            return
        passed = numpy.ones(len(rows), bool) if self._lines is None else self._lines[rows["line"]]
        if self._test is not None:
            passed &= self._test(rows) | is_mark(rows)
        found = rows["number"][passed]
        needed = self.count + len(found)
        if needed > len(self._numbers):
            grown = numpy.zeros(max(needed, 2 * len(self._numbers)), numpy.uint32)
            grown[: self.count] = self._numbers[: self.count]
            self._numbers = grown
        self._numbers[self.count : needed] = found
        self.count = needed
