"""Sorts the rows of a trace's file by identifier, then by time, and restores the order of recording.

A query for one identifier then reads only a few row groups of a file, and similar rows compress well. The column `row`
distinguishes entries of the same time: 0, 1, 2, ... in their order. If the clock of a log runs backwards, `row`
is the place in the file, and the fact `order` of the file's metadata says "row" in place of "time_ns, row".
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from canwire.logs.batch import LogBatch
from canwire.values.record import EXTENDED, load_numpy

if TYPE_CHECKING:
    import numpy

ROW = "row"
BY_TIME, BY_ROW = "time_ns, row", "row"


def rows_among(records: numpy.ndarray) -> tuple[Any, str]:
    """Return the column `row` for records in the order of recording, and the name of the order that restores it."""
    numpy = load_numpy()
    count = len(records)
    times = records["time_ns"]
    if count > 1 and not (times[1:] >= times[:-1]).all():
        return numpy.arange(count, dtype="u4"), BY_ROW
    places = numpy.arange(count)
    first = numpy.ones(count, bool)
    first[1:] = times[1:] != times[:-1]
    return (places - numpy.maximum.accumulate(numpy.where(first, places, 0))).astype("u4"), BY_TIME


def by_identifier(records: numpy.ndarray) -> Any:
    """The order of records by kind, format and identifier; records of one identifier keep their order."""
    numpy = load_numpy()
    extended = (records["info"] & EXTENDED != 0).astype("u8")
    keys = records["kind"].astype("u8") << 33 | extended << 32 | records["id"]
    different, numbers = numpy.unique(keys, return_inverse=True)
    small = numbers.astype("u2") if len(different) <= 1 << 16 else numbers  # sorted in linear time
    return numpy.argsort(small, kind="stable")


def in_order(batch: LogBatch, rows: Any, order: str) -> LogBatch:
    """Return the records in the order in which they were recorded."""
    numpy = load_numpy()
    times = batch.records["time_ns"]
    if order == BY_ROW:
        places = numpy.argsort(rows, kind="stable")
    elif rows.any():
        places = numpy.lexsort((rows, times))
    else:
        places = numpy.argsort(times, kind="stable")  # it makes use of what is in order already
    return LogBatch(batch.records[places], batch.channels)
