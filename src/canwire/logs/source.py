"""A file while it is read: its bytes, what is learnt of it, and what was wrong in it and where."""

from __future__ import annotations

from collections.abc import Iterable
from typing import BinaryIO, NamedTuple

from canwire.logs.batch import LogBatch, batch_of
from canwire.logs.entry import LogEntry

MOST_FAULTS = 1000
"""Faults of a file that are kept one by one; the rest is counted."""


DATED_NS = 10**17
"""Time stamps from here on, 1973, are dates: no log counts three years from its own zero."""


class LogFault(NamedTuple):
    """Something in a file that could not be read: `where` is "line 12" or "byte 4096"."""

    where: str
    what: str

    def __str__(self) -> str:
        return f"{self.where}: {self.what}"


class Source:
    """What a reader is given, and tells: see the attributes of `Log`, which are these."""

    def __init__(self, path: str, file: BinaryIO) -> None:
        self.path = path
        self.file = file
        self.channels: list[str] = []
        self.dated = False
        self.start_ns: int | None = None
        self.clock = ""
        self.faults: list[LogFault] = []
        self.fault_count = 0

    def fault(self, where: str, what: str) -> None:
        """Count something wrong, and keep it if there are not too many."""
        self.fault_count += 1
        if len(self.faults) < MOST_FAULTS:
            self.faults.append(LogFault(where, what))

    def channel(self, name: str) -> int:
        """The number of a channel's name; a new one gets the next."""
        if name not in self.channels:
            self.channels.append(name)
        return self.channels.index(name)

    def infer_date(self, time_ns: int) -> None:
        """What a time stamp tells: beyond 1973 they count from 1970."""
        self.dated = self.dated or time_ns >= DATED_NS

    def batch(self, entries: Iterable[LogEntry]) -> LogBatch:
        """Entries as a batch of this log."""
        return batch_of(entries, self.channels)
