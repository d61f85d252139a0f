"""Writes a trace: entries are kept in memory until a file is full, and also in a journal once `sync` was called.

A full file is packed in another thread (packing.py) while the next one grows; until it is complete, its journal
remains.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, ClassVar, cast

from canwire.errors import BadValue
from canwire.logs import journal
from canwire.logs.batch import LOG_RECORD_SIZE, log_dtype
from canwire.logs.entry import LogKind
from canwire.logs.form import FormWriter
from canwire.logs.journal import SUFFIX
from canwire.logs.tables.arrow import load_pyarrow
from canwire.logs.trace.files import file_name
from canwire.logs.trace.packing import Packing, end_journal
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

ENTRIES = 1 << 20
"""Of a file: 88 MiB in memory while it grows, some 6 to 12 MB when it is whole; five minutes of a saturated bus."""


class Writer(FormWriter):
    """Writes files of at most ENTRIES entries into a new or empty folder."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)
    opens: ClassVar[bool] = False

    def begin(self) -> None:
        load_pyarrow()
        if self.path == "-":
            raise BadValue("trace: a folder, which cannot be written to standard output")
        os.makedirs(self.path, exist_ok=True)
        if os.listdir(self.path):
            raise BadValue(f"{self.path}: a folder that is not empty; give the trace a new one")
        self._about: dict[str, Any] = {
            "version": 1, "dated": self.dated, "start_ns": self.start_ns, "clock": self.clock}  # fmt: skip
        self._records = load_numpy().empty(ENTRIES, log_dtype())
        self._held = 0
        self._whole = 0  # entries in files that are
        self._number = 1
        self._packing: Packing | None = None
        self._journal: journal.Writer | None = None
        self._flushed = False

    def put(self, records: numpy.ndarray) -> None:
        while len(records):
            if self._held == len(self._records):
                self.turn()
            taken = records[: len(self._records) - self._held]
            self._records[self._held : self._held + len(taken)] = taken
            self._held += len(taken)
            records = records[len(taken) :]
            if self._flushed:
                self._log(taken)

    def sync(self) -> None:
        """Flush the journal; from the first call on all records are also written to a journal."""
        if not self._flushed:
            self._finish()
            self._flushed = True
            self._log(self._records[: self._held])
        if self._journal is not None:
            try:
                self._journal.sync()
            finally:
                self._count()
        if self._packing is not None and self._packing.done:
            self._finish()

    def grown(self) -> int:
        return self._held * LOG_RECORD_SIZE

    def turn(self) -> bool:
        """Complete the growing file, and begin another."""
        self._finish()
        if self._held:
            path = os.path.join(self.path, file_name(self._number))
            if self._journal is not None:
                self._journal.sync()
            self._packing = Packing(
                path, self._records[: self._held], self.channels, self._about, self._journal
            )
            self._records = load_numpy().empty(ENTRIES, log_dtype())
            self._held = 0
            self._journal = None
            self._number += 1
        return True

    def end(self) -> None:
        """Complete the last file. Raises OSError if it does not fit; flushed entries are then in its journal."""
        try:
            self.turn()
            self._finish()
            if self._number == 1:
                Packing(
                    os.path.join(self.path, file_name(1)), self._records[:0], [], self._about, None
                ).finish()
        finally:
            for growing in self._journals():
                end_journal(growing)

    def _finish(self) -> None:
        """Wait until the file that is being packed, if any, is complete."""
        if self._packing is not None:
            try:
                self._packing.finish()
                self._whole += len(self._packing.records)
                self._packing = None
            finally:
                self._count()

    def _log(self, records: numpy.ndarray) -> None:
        if self._journal is None:
            path = os.path.join(self.path, file_name(self._number) + SUFFIX)
            file = cast(Any, open(path, "wb", buffering=0))  # noqa: SIM115
            self._journal = journal.Writer(
                path, file, dated=self.dated, start_ns=self.start_ns, clock=self.clock
            )
            self._journal.channels = self.channels
            self._journal.begin()
        try:
            self._journal.put(records)
        finally:
            self._count()

    def _count(self) -> None:
        self.count = self._whole + sum(growing.count for growing in self._journals())

    def _journals(self) -> list[journal.Writer]:
        """Return the journals that their files have not replaced yet."""
        packed = None if self._packing is None else self._packing.growing
        return [growing for growing in (packed, self._journal) if growing is not None]
