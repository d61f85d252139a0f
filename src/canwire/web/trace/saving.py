"""Writes rows of a trace as a log of any format; rows that report missing data become marks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy

from canwire import LogBatch, LogEntry, LogKind, LogMark, LogWriter, MarkKind, log_dtype
from canwire.web.trace.store.history import Era
from canwire.web.trace.store.kinds import is_frame, is_lin, is_mark, is_sent
from canwire.web.trace.store.lin import plain_lin
from canwire.web.trace.store.rows import EVERY_LINE, LOST

if TYPE_CHECKING:
    from collections.abc import Mapping


def write_rows(
    writer: LogWriter, rows: numpy.ndarray, names: Mapping[int, str], eras: Sequence[Era], *, errors: bool
) -> int:
    """Write the rows of the lines in `names`, which are their channels by number; returns how many.

    Without `errors`, only frames and marks are written. Raises OSError for a full disk.
    """
    wanted = is_frame(rows) | is_mark(rows)
    if errors:
        wanted |= numpy.isin(rows["record"]["info"] & 0x1F, (2, 3))
    wanted &= numpy.isin(rows["line"], [*names, EVERY_LINE])
    rows = rows[wanted]
    epochs = _epochs(rows, eras)
    marks = is_mark(rows)
    for part in numpy.split(numpy.arange(len(rows)), numpy.flatnonzero(numpy.diff(marks)) + 1):
        if not len(part):
            continue
        if marks[part[0]]:
            writer.write_many(_marks(rows[part], epochs[part], names, writer.format))
        else:
            writer.write_batch(_batch(rows[part], epochs[part], names))
    return len(rows)


def _epochs(rows: numpy.ndarray, eras: Sequence[Era]) -> numpy.ndarray:
    """Return the time to add to each row's time, by the hub that the row came from."""
    firsts = numpy.array([era.first for era in eras], numpy.uint64)
    places = numpy.searchsorted(firsts, rows["number"].astype(numpy.uint64), "right") - 1
    return numpy.array([era.epoch_ns for era in eras], numpy.uint64)[numpy.maximum(places, 0)]


def _batch(rows: numpy.ndarray, epochs: numpy.ndarray, names: Mapping[int, str]) -> LogBatch:
    channels = list(dict.fromkeys(names.values()))
    table = numpy.zeros(EVERY_LINE + 1, numpy.uint16)
    for number, name in names.items():
        table[number] = channels.index(name)
    records = numpy.zeros(len(rows), log_dtype())
    lin, frames = is_lin(rows), is_frame(rows)
    record = rows["record"].copy()
    record[lin] = plain_lin(record[lin])
    for field in ("id", "info", "data"):
        records[field] = record[field]
    records["time_ns"] = record["time_ns"] + epochs
    records["channel"] = table[rows["line"]]
    kinds = numpy.where(frames, LogKind.CAN_FRAME, LogKind.CAN_EVENT)
    records["kind"] = numpy.where(lin, numpy.where(frames, LogKind.LIN_FRAME, LogKind.LIN_EVENT), kinds)
    records["direction"] = numpy.where(frames, numpy.where(is_sent(rows), 2, 1), 0)
    return LogBatch(records, channels)


def _marks(
    rows: numpy.ndarray, epochs: numpy.ndarray, names: Mapping[int, str], form: str
) -> Iterable[LogEntry]:
    """Yield the marks of the rows. candump has no gaps: there each is an error frame (receive overflow), as lost
    records are."""
    every = next(iter(names.values()), "can0")
    for row, epoch in zip(rows, epochs, strict=True):
        count = int.from_bytes(row["record"]["data"][:8].tobytes(), "little")
        stamp_ns = int(row["record"]["time_ns"]) + int(epoch)
        lost = int(row["record"]["info"]) == LOST
        kind = MarkKind.LOST if lost or form == "candump" else MarkKind.GAP
        count = count if lost else 0 if kind is MarkKind.LOST else count * 1_000_000
        yield LogEntry(stamp_ns, names.get(int(row["line"]), every), LogMark(kind, stamp_ns, count))
