"""A trace out: entries gather in memory until a file of them is full, and once `sync` was called in a journal, too.

Two ways were possible where the growing file is concerned: small files, put together now and then, or a journal. A file
that is put together exists twice for a moment, or not at all; a journal is replaced by its file in one step.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from typing import TYPE_CHECKING, Any, ClassVar, cast

from canwire.errors import BadValue
from canwire.logs import journal
from canwire.logs.batch import LOG_RECORD_SIZE, log_dtype
from canwire.logs.entry import LogKind
from canwire.logs.form import FormWriter
from canwire.logs.journal import SUFFIX
from canwire.logs.tables.arrow import load_pyarrow, schema_of_log, table_of
from canwire.logs.tables.order import ROW, by_identifier, rows_among
from canwire.logs.tables.parquet_file import ABOUT, PACKING, ROW_GROUP
from canwire.logs.trace.files import file_name
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

ENTRIES = 1 << 20
"""Of a file: 88 MiB in memory while it grows, some 6 to 10 MB when it is whole; five minutes of a saturated bus."""


class Writer(FormWriter):
    """Files of at most ENTRIES; the folder is new, or empty."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)
    opens: ClassVar[bool] = False

    def begin(self) -> None:
        self._arrow = load_pyarrow()
        if self.path == "-":
            raise BadValue("trace: a folder, which cannot be written to standard output")
        os.makedirs(self.path, exist_ok=True)
        if os.listdir(self.path):
            raise BadValue(f"{self.path}: a folder that is not empty; give the trace a new one")
        self._records = load_numpy().empty(ENTRIES, log_dtype())
        self._held = 0
        self._whole = 0  # entries in files that are
        self._number = 1
        self._journal: journal.Writer | None = None
        self._journals = False

    def put(self, records: numpy.ndarray) -> None:
        while len(records):
            if self._held == ENTRIES:
                self.turn()
            taken = records[: ENTRIES - self._held]
            self._records[self._held : self._held + len(taken)] = taken
            self._held += len(taken)
            records = records[len(taken) :]
            if self._journals:
                self._log(taken)

    def sync(self) -> None:
        """From the first time on everything goes into a journal as well."""
        if not self._journals:
            self._journals = True
            self._log(self._records[: self._held])
        if self._journal is not None:
            self._journal.sync()
            self._count()

    def grown(self) -> int:
        return self._held * LOG_RECORD_SIZE

    def turn(self) -> bool:
        """Make the growing file whole, and begin another."""
        if self._held:
            self._write(self._records[: self._held])
            self._whole += self._held
            self._held = 0
            self._number += 1
        growing, self._journal = self._journal, None
        if growing is not None:
            assert growing.file is not None
            growing.file.close()
            os.remove(growing.path)
        self.count = self._whole
        return True

    def end(self) -> None:
        try:
            self.turn()
        finally:
            if self._journal is not None and self._journal.file is not None:
                self._journal.file.close()
        if self._number == 1:
            self._write(self._records[:0])

    def _log(self, records: numpy.ndarray) -> None:
        if self._journal is None:
            path = os.path.join(self.path, file_name(self._number) + SUFFIX)
            file = cast(Any, open(path, "wb", buffering=0))  # noqa: SIM115
            about = {"dated": self.dated, "start_ns": self.start_ns, "clock": self.clock}
            self._journal = journal.Writer(path, file, **about)  # type: ignore[arg-type]
            self._journal.channels = self.channels
            self._journal.begin()
        try:
            self._journal.put(records)
        finally:
            self._count()

    def _count(self) -> None:
        self.count = self._whole + (self._journal.count if self._journal is not None else 0)

    def _write(self, records: numpy.ndarray) -> None:
        """A file, there as a whole or not at all."""
        path = os.path.join(self.path, file_name(self._number))
        rows, order = rows_among(records)
        places = by_identifier(records)
        about = {"version": 1, "dated": self.dated, "start_ns": self.start_ns, "clock": self.clock}
        schema = schema_of_log(self._arrow)
        table = table_of(self._arrow, schema, records[places], self.channels)
        table = table.append_column(ROW, self._arrow.array(rows[places]))
        table = table.replace_schema_metadata({ABOUT: json.dumps({**about, "order": order}).encode()})
        packing = {**PACKING, "use_dictionary": [*PACKING["use_dictionary"], ROW]}
        try:
            with open(f"{path}.new", "wb") as file:
                self._arrow.parquet.write_table(table, file, row_group_size=ROW_GROUP, **packing)
            os.replace(f"{path}.new", path)
        except BaseException:
            with suppress(OSError):
                os.remove(f"{path}.new")
            raise
