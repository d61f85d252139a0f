"""A file during reading: its bytes, the facts about it, and its faults with their places."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import BinaryIO, NamedTuple

from canwire.errors import BadLog, BadValue
from canwire.logs.batch import LogBatch, batch_of, record_of
from canwire.logs.entry import LogEntry
from canwire.logs.limits import USUAL, LogLimits

MOST_FAULTS = 1000
"""Number of faults that are kept; further ones are only counted."""


DATED_NS = 10**17
"""Time stamps from here on, 1973, are dates: no log counts three years from its own zero."""


_NO_RECORD = (BadValue, struct.error, OverflowError)


class LogFault(NamedTuple):
    """Something in a file that could not be read: `where` is "line 12" or "byte 4096"."""

    where: str
    what: str

    def __str__(self) -> str:
        return f"{self.where}: {self.what}"


class Source:
    """The input and the results of a reader; `Log` has the same attributes."""

    def __init__(self, path: str, file: BinaryIO, limits: LogLimits = USUAL) -> None:
        self.path = path
        self.file = file
        self.limits = limits
        self.channels: list[str] = []
        self._numbers: dict[str, int] = {}
        self.dated = False
        self.start_ns: int | None = None
        self.clock = ""
        self.faults: list[LogFault] = []
        self.fault_count = 0

    def fault(self, where: str, what: str) -> None:
        """Count a fault, and keep it unless there are too many."""
        self.fault_count += 1
        if len(self.faults) < MOST_FAULTS:
            self.faults.append(LogFault(where, what))

    def channel(self, name: str) -> int:
        """Return the number of a channel's name; a new name gets the next number."""
        number = self._numbers.get(name)
        if number is None:
            if len(self._numbers) != len(self.channels):  # `batch` has added some
                self._numbers = {known: number for number, known in enumerate(self.channels)}
            if name not in self._numbers:
                self._numbers[name] = len(self.channels)
                self.channels.append(name)
                self._check_channels()
            number = self._numbers[name]
        return number

    def beyond(self, limit: str, what: str) -> BadLog:
        """Return the error for exceeding the limit of this name."""
        most = getattr(self.limits, limit)
        return BadLog(
            f"{self.path}: {what} than {limit}={most}; open it with a larger one in limits=LogLimits()"
        )

    def infer_date(self, time_ns: int) -> None:
        """Learn from a time stamp: after 1973, stamps count from 1970."""
        self.dated = self.dated or time_ns >= DATED_NS

    def batch(self, entries: Iterable[LogEntry]) -> LogBatch:
        """Convert entries to a batch of this log; an entry with numbers that no record can hold is a fault."""
        listed = list(entries)
        try:
            found = batch_of(listed, self.channels)
        except _NO_RECORD:
            found = batch_of(list(filter(self._is_sound, listed)), self.channels)
        self._check_channels()
        return found

    def _is_sound(self, entry: LogEntry) -> bool:
        try:
            record_of(entry, 0)
        except _NO_RECORD as error:
            self.fault("entry", f"nothing that a log holds: {error}")
            return False
        return True

    def _check_channels(self) -> None:
        if len(self.channels) > self.limits.channels:
            raise self.beyond("channels", "more channels")
