"""Logs that were opened in the page: each is read into a separate history, and shown like live data."""

from __future__ import annotations

import secrets
import tempfile
import threading
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

import numpy

from canwire import BadValue, CanwireError, LogBatch, LogKind, MarkKind, open_log
from canwire.web.trace.source import newest_ns
from canwire.web.trace.store.history import History
from canwire.web.trace.store.lin import rows_of_lin
from canwire.web.trace.store.rows import EVERY_LINE, GAP, LATE, LOST, mark_row, row_dtype, rows_of
from canwire.web.trace.taps import Watched
from canwire.web.words import Trouble

if TYPE_CHECKING:
    from numpy.typing import NDArray

MOST_OPEN = 8
MOST_BYTES = 8 << 30  # of a file
_SENT, _LIN_SENT = 1 << 21, 1 << 25  # of the info word


class OpenedLog:
    """A log as a source. A thread reads it, and its rows are visible meanwhile; `trouble` reports unreadable parts."""

    live = False

    def __init__(self, name: str, folder: tempfile.TemporaryDirectory[str], path: Path) -> None:
        self.name = name
        self.history = History()
        self._trouble = ""
        self._folder = folder
        self._channels: list[str] = []
        self._lin: set[int] = set()  # channels with LIN
        self._ends = threading.Event()
        self._begun = threading.Event()
        self._zero_ns: int | None = None
        self._newest_ns = 0
        self._thread = threading.Thread(target=self._run, args=(path,), name=f"reading {name}")
        self._thread.start()

    @property
    def trouble(self) -> str:
        return self._trouble or self.history.trouble

    @property
    def reading(self) -> bool:
        return self._thread.is_alive()

    @property
    def channels(self) -> list[str]:
        """The names of its channels so far."""
        return list(self._channels)

    def wait(self, timeout_s: float) -> None:
        """Wait at most this number of seconds until the first rows are there or the reader has ended."""
        self._begun.wait(timeout_s)

    def kind_of(self, channel: str) -> str:
        """Return "LIN" for a channel on which LIN entries were found so far, else "CAN"."""
        return "LIN" if self.channels.index(channel) in self._lin else "CAN"

    def want(self, viewer: object, addresses: Collection[str]) -> None:
        """Do nothing: the whole log is read in any case."""

    def indices(self, addresses: Collection[str]) -> list[int]:
        channels = self.channels
        return [channels.index(address) for address in addresses if address in channels]

    def lines(self, addresses: Collection[str]) -> list[Watched]:
        channels = self.channels
        return [Watched(channels.index(one), one, one, 0, "", True) for one in addresses if one in channels]

    def bus_of(self, number: int) -> str:
        channels = self.channels
        return channels[number] if 0 <= number < len(channels) else ""

    def now_ns(self) -> int:
        return newest_ns(self.history)

    def close(self) -> None:
        """Close the log and remove its rows; a second call does nothing."""
        self._ends.set()
        self._thread.join()
        self.history.close()
        self._folder.cleanup()

    def _run(self, path: Path) -> None:
        try:
            with open_log(path) as log:
                for batch in log.batches():
                    if self._ends.is_set():
                        return
                    if self._zero_ns is None:
                        self._zero_ns = int(batch.records["time_ns"].min()) if log.dated else 0
                        self.history.begin_era(self._zero_ns)
                    self._channels = list(batch.channels)
                    self._lin |= set(batch.records["channel"][_is_lin(batch.records)].tolist())
                    self._append(_rows(batch))
                    self._begun.set()
                if log.fault_count:
                    self._trouble = Trouble.said(
                        f"{log.fault_count} places could not be read; first {log.faults[0]}", "logfaults"
                    )
        except (CanwireError, OSError) as error:
            self._trouble = Trouble.of(error)
        finally:
            self._begun.set()

    def _append(self, rows: numpy.ndarray) -> None:
        stamps = numpy.maximum(rows["record"]["time_ns"], self._zero_ns or 0) - numpy.uint64(
            self._zero_ns or 0
        )
        rows["record"]["time_ns"] = stamps
        if (stamps[1:] < stamps[:-1]).any():
            rows = rows[numpy.argsort(stamps, kind="stable")]
        if len(rows):
            rows["flags"] = numpy.where(rows["record"]["time_ns"] < self._newest_ns, LATE, 0)
            self._newest_ns = max(self._newest_ns, int(rows["record"]["time_ns"][-1]))
            self.history.append(rows)


class OpenedLogs:
    """The open logs of a server, by their keys."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._logs: dict[str, OpenedLog] = {}

    @property
    def logs(self) -> dict[str, OpenedLog]:
        with self._lock:
            return dict(self._logs)

    def open(self, name: str, folder: tempfile.TemporaryDirectory[str], path: Path) -> str:
        """Read this file, whose folder is removed together with it; raises BadValue if too many logs are open."""
        with self._lock:
            if len(self._logs) >= MOST_OPEN:
                raise BadValue(f"{MOST_OPEN} logs are open; close one first")
            key = f"log-{secrets.token_hex(4)}"  # a tab may come back with one of a server that has ended
            self._logs[key] = OpenedLog(name, folder, path)
        return key

    def find(self, key: str) -> OpenedLog:
        """Return an open log; raises BadValue if it is not open."""
        log = self.logs.get(key)
        if log is None:
            raise BadValue(f"{key}: this log is not open any more")
        return log

    def close(self, key: str) -> None:
        log = self.find(key)
        with self._lock:
            self._logs.pop(key, None)
        log.close()

    def close_all(self) -> None:
        for key in self.logs:
            self.close(key)


def _is_lin(records: numpy.ndarray) -> NDArray[numpy.bool_]:
    return numpy.isin(records["kind"], (LogKind.LIN_FRAME, LogKind.LIN_EVENT))


def _rows(batch: LogBatch) -> numpy.ndarray:
    """Convert a log's records to rows; marks are left out unless they report a loss."""
    records = batch.records
    plain: NDArray[numpy.uint8] = records.view(numpy.uint8).reshape(len(records), records.itemsize)[:, :80]
    rows = rows_of(numpy.zeros(len(records), row_dtype()["record"]), 0)
    rows["record"] = numpy.ascontiguousarray(plain).view(row_dtype()["record"]).reshape(-1)
    rows["line"] = records["channel"]
    lin = _is_lin(records)
    if lin.any():
        rows["record"][lin] = rows_of_lin(rows["record"][lin])
    sent = records["direction"] == 2
    rows["record"]["info"] |= numpy.where(sent, numpy.where(lin, _LIN_SENT, _SENT), 0).astype(numpy.uint32)
    marks = records["kind"] == LogKind.MARK
    if marks.any():
        kept = ~marks
        for at in numpy.flatnonzero(marks):
            kind = {int(MarkKind.LOST): LOST, int(MarkKind.GAP): GAP}.get(int(records["id"][at]))
            if kind is not None:
                count = int.from_bytes(records["data"][at, :8].tobytes(), "little")
                line = int(records["channel"][at]) if kind == LOST else EVERY_LINE
                count = count if kind == LOST else count // 1_000_000
                rows[at] = mark_row(kind, line, count, int(records["time_ns"][at]))[0]
                kept[at] = True
        rows = rows[kept]
    return rows
