"""Collects signals of a log."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from canwire import LinFrame, LogBatch, LogKind, open_log, record_dtype
from canwire.commands.logs.faults import tell_faults
from canwire.commands.plot.decoding import Decoding

if TYPE_CHECKING:
    from canwire.commands.plot.choosing import Chosen
    from canwire.commands.plot.tracks import Tracks


def read_tracks(arguments: argparse.Namespace, chosen: Chosen, tracks: Tracks) -> int:
    """Read the log in batches; returns the number of its faults. Raises BadLog, BadValue."""
    decoding = Decoding(chosen, tracks)
    zero_ns: int | None = None
    with open_log(arguments.source, format=arguments.form) as log:
        try:
            for batch in log.batches():
                if zero_ns is None:
                    zero_ns = int(batch.records["time_ns"][0])
                _add(arguments, decoding, batch, zero_ns)
        finally:
            tell_faults(log)
        return log.fault_count


def _add(arguments: argparse.Namespace, decoding: Decoding, batch: LogBatch, zero_ns: int) -> None:
    records = _between(batch.records, arguments.begin, arguments.end, zero_ns)
    for number, channel in enumerate(batch.channels):
        if arguments.channel not in (None, channel):
            continue
        here = records[records["channel"] == number]
        frames = here[here["kind"] == LogKind.CAN_FRAME]
        if len(frames):
            decoding.add(channel, _plain(frames), zero_ns)
        for entry in LogBatch(here[here["kind"] == LogKind.LIN_FRAME], batch.channels):
            if isinstance(entry.content, LinFrame):
                decoding.add_lin(channel, entry.content, zero_ns)


def _between(records: Any, begin_s: float | None, end_s: float | None, zero_ns: int) -> Any:
    if begin_s is None and end_s is None:
        return records
    times_s = (records["time_ns"].astype("i8") - zero_ns) / 1e9
    keep = times_s >= (begin_s or 0.0)
    return records[keep if end_s is None else keep & (times_s <= end_s)]


def _plain(frames: Any) -> Any:
    """Return the records of a log as records of a line."""
    import numpy

    found = numpy.zeros(len(frames), record_dtype())
    for name in ("time_ns", "id", "info", "data"):
        found[name] = frames[name]
    return found
