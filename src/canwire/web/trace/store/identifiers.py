"""One row for each frame identifier: the number of frames, their distances, and when each byte changed last."""

from __future__ import annotations

import threading
from collections.abc import Collection
from typing import TYPE_CHECKING, NamedTuple

import numpy

from canwire.web.trace.store.kinds import Test, identifiers, is_frame, is_lin, is_mark, kind_of, lengths
from canwire.web.trace.store.rows import EVERY_LINE, row_dtype

if TYPE_CHECKING:
    from numpy.typing import NDArray

MOST = 65_536  # different frames; rows of others are counted in `left_out`
_FD_AT, _FORMATS_AT, _HEADER_AT = (
    10,
    21,
    27,
)  # bits of the info word that make a frame another one, with its kind
_EXTRA = numpy.dtype(
    [("count", "<f8"), ("cycle", "<f8"), ("least", "<f8"), ("most", "<f8"), ("mean", "<f8"),
     ("changed", "<u8", 64)]
)  # fmt: skip


class Page(NamedTuple):
    """Rows of the table from place `at` on; `length` is the number of rows that match."""

    length: int
    at: int
    rows: numpy.ndarray
    extra: numpy.ndarray


class Identifiers:
    """A table of a history's frames, updated by its writer; any thread may read it. Times are in nanoseconds of the
    hub.

    For each frame it contains the latest row, the count, the last, smallest, largest and mean distance of two frames (0
    before the second frame), and when each byte changed last. `left_out` counts rows for which the table was full.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._places: dict[int, int] = {}
        self._rows = numpy.zeros(64, row_dtype())
        self._extra = numpy.zeros(64, _EXTRA)
        self._width = 0  # bytes that any of them had
        self.left_out = 0

    def counts(self) -> NDArray[numpy.float64]:
        """Return the number of frames of each row of the table, in the order of first occurrence."""
        with self._lock:
            found: NDArray[numpy.float64] = self._extra["count"][: len(self._places)].copy()
        return found

    def page(
        self, lines: Collection[int], test: Test | None, before: NDArray[numpy.float64], at: int, count: int
    ) -> Page:
        """Return the frames of these lines that pass and arrived since their counts were `before`, by line and
        identifier."""
        with self._lock:
            rows, extra = self._rows[: len(self._places)], self._extra[: len(self._places)]
            base = numpy.zeros(len(rows))
            base[: len(before)] = before
            passed = numpy.isin(rows["line"], list(lines)) & (extra["count"] > base)
            if test is not None:
                passed &= test(rows)
            order = numpy.flatnonzero(passed)
            some = rows[order]
            order = order[numpy.lexsort((identifiers(some), ~is_frame(some), some["line"]))]
            at = max(0, min(at, len(order) - count))
            shown = order[at : at + count]
            found = Page(len(order), at, rows[shown], extra[shown])
        found.extra["count"] -= base[shown]
        return found

    def restart(self) -> None:
        """Time restarts: distances to earlier rows are meaningless."""
        with self._lock:
            for name in ("cycle", "least", "most", "mean", "changed"):
                self._extra[name] = 0
            self._rows["record"]["time_ns"] = 0

    def copy(self) -> Identifiers:
        """A copy of the present state."""
        made = Identifiers()
        with self._lock:
            made._places, made._rows = dict(self._places), self._rows.copy()
            made._extra, made.left_out = self._extra.copy(), self.left_out
            made._width = self._width
        return made

    def add(self, rows: numpy.ndarray) -> None:
        """Add rows of the history, in its order."""
        wanted = ~is_mark(rows) & (rows["line"] != EVERY_LINE)
        rows = rows if wanted.all() else rows[wanted]
        if len(rows):
            with self._lock:
                self._take(rows)

    def _take(self, rows: numpy.ndarray) -> None:
        keys = _keys(rows)
        found, first, inverse = numpy.unique(keys, return_index=True, return_inverse=True)
        places = numpy.array(
            [self._place(key, rows, at) for key, at in zip(found.tolist(), first.tolist(), strict=True)]
        )
        every = places[inverse.reshape(-1)]
        order = numpy.argsort(every, kind="stable")
        beyond = int(numpy.searchsorted(every[order], 0))
        self.left_out += beyond
        if beyond < len(rows):
            order = order[beyond:]
            self._add(rows, order, every[order])

    def _add(self, rows: numpy.ndarray, order: NDArray[numpy.intp], places: NDArray[numpy.intp]) -> None:
        """Add rows in this order, sorted by frame; `places` are their places in the table."""
        begins = numpy.flatnonzero(numpy.r_[True, places[1:] != places[:-1]])
        ends = numpy.r_[begins[1:], len(order)] - 1
        which = places[begins]
        extra = self._extra[which]
        record = rows["record"]
        stamps = record["time_ns"][order].astype(numpy.int64)
        before = numpy.r_[0, stamps[:-1]]
        before[begins] = self._rows["record"]["time_ns"][which]
        apart = numpy.where(before == 0, 0, stamps - before).astype(float)  # 0: the first one
        known = apart > 0
        self._width = width = max(self._width, int(lengths(rows).max()))
        data = record["data"][order, :width]
        before_data = numpy.roll(data, 1, axis=0)
        before_data[begins] = self._rows["record"]["data"][which, :width]
        changed = (data != before_data) & known[:, None]
        changed_ns = numpy.maximum.reduceat(numpy.where(changed, stamps[:, None], 0), begins)
        extra["changed"][:, :width] = numpy.maximum(
            extra["changed"][:, :width], changed_ns.astype(numpy.uint64)
        )
        _measure(extra, apart, known, begins, ends)
        extra["count"] += ends - begins + 1
        self._extra[which] = extra
        self._rows[which] = rows[order[ends]]

    def _place(self, key: int, rows: numpy.ndarray, at: int) -> int:
        place = self._places.get(key)
        if place is None:
            if len(self._places) >= MOST:
                return -1
            place = len(self._places)
            if place == len(self._rows):
                self._rows = numpy.concatenate((self._rows, numpy.zeros(place, row_dtype())))
                self._extra = numpy.concatenate((self._extra, numpy.zeros(place, _EXTRA)))
            self._rows[place] = rows[at]
            self._rows[place]["record"]["time_ns"] = 0  # until it is added
            self._extra[place] = 0
            self._places[key] = place
        return place


def _measure(
    extra: numpy.ndarray,
    apart: NDArray[numpy.float64],
    known: NDArray[numpy.bool_],
    begins: NDArray[numpy.intp],
    ends: NDArray[numpy.intp],
) -> None:
    """Update the last, smallest, largest and mean distance by the known distances of these rows."""
    least = numpy.minimum.reduceat(numpy.where(known, apart, numpy.inf), begins)
    least = numpy.minimum(least, numpy.where(extra["least"] > 0, extra["least"], numpy.inf))
    extra["least"] = numpy.where(numpy.isfinite(least), least, 0)
    extra["most"] = numpy.maximum(extra["most"], numpy.maximum.reduceat(apart, begins))
    extra["cycle"] = numpy.where(apart[ends] > 0, apart[ends], extra["cycle"])
    count = numpy.add.reduceat(known, begins)
    mean = numpy.add.reduceat(apart, begins) / numpy.maximum(count, 1)
    # the mean of about the last hundred distances, so that it follows a change of the cycle
    share = numpy.where(extra["mean"] > 0, numpy.minimum(count / 100, 1), 1)
    extra["mean"] = numpy.where(count > 0, extra["mean"] + (mean - extra["mean"]) * share, extra["mean"])


def _keys(rows: numpy.ndarray) -> NDArray[numpy.uint64]:
    """Return a key for each row that is equal for rows of one frame: line, identifier, kind, and format."""
    info, kind = rows["record"]["info"], kind_of(rows)
    of_can = (info >> _FD_AT & 1) << 8 | (info >> _FORMATS_AT & 7) << 9
    of_lin = (info >> _HEADER_AT & 1) << 12
    keys: NDArray[numpy.uint64] = rows["line"].astype(numpy.uint64) * numpy.uint64(1 << 48)
    keys |= identifiers(rows) * numpy.uint64(1 << 16)
    keys |= kind | numpy.where(is_lin(rows), of_lin, of_can)
    return keys
