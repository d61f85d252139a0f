"""Parquet: the columns of columns.py, in the order of a log or of a trace's files. Needs canwire[parquet]."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING, Any, ClassVar

from canwire.errors import BadLog
from canwire.logs.batch import LogBatch
from canwire.logs.entry import LogKind
from canwire.logs.form import FormWriter
from canwire.logs.source import DATED_NS, Source
from canwire.logs.tables.arrow import FOR_PANDAS, batch_of_table, load_pyarrow, schema_of_log, table_of
from canwire.logs.tables.columns import COLUMNS
from canwire.logs.tables.order import ROW, in_order
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

ROW_GROUP = 1 << 17
ABOUT = b"canwire"
_WORDS = ("channel", "direction", "type")
_DIFFERENCES = {"time_ns": "DELTA_BINARY_PACKED", "data": "DELTA_BYTE_ARRAY"}
PACKING: dict[str, Any] = {
    "compression": "zstd",
    "use_dictionary": [name for name in COLUMNS if name not in _DIFFERENCES],
    "column_encoding": _DIFFERENCES,
    "write_page_checksum": True,
}
"""How columns are packed: times and data by what changes, the rest by the few values that there are."""


class Writer(FormWriter):
    """Row groups of some 100,000 entries, compressed with zstd; readable once it is closed."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)
    opens: ClassVar[bool] = True
    needs_end: ClassVar[bool] = True

    def begin(self) -> None:
        self._arrow = load_pyarrow()
        about = {"version": 1, "dated": self.dated, "start_ns": self.start_ns, "clock": self.clock}
        schema = schema_of_log(self._arrow).with_metadata({ABOUT: json.dumps(about).encode(), **FOR_PANDAS})
        self._sink = self._arrow.parquet.ParquetWriter(self.file, schema, **PACKING)
        self._schema = schema
        self._parts: list[Any] = []
        self._held = 0

    def put(self, records: numpy.ndarray) -> None:
        self._parts.append(records)
        self._held += len(records)
        if self._held >= ROW_GROUP:
            self._put_group()

    def sync(self) -> None:
        """Do nothing: the file is complete only at its end."""

    def end(self) -> None:
        try:
            self._put_group()
        finally:
            self._sink.close()

    def give_up(self) -> None:
        self._parts = []
        with suppress(OSError):  # it writes the end of a file that nobody wants
            self._sink.close()

    def _put_group(self) -> None:
        if self._held:
            records = load_numpy().concatenate(self._parts)
            self._parts, self._held = [], 0
            self._sink.write_table(table_of(self._arrow, self._schema, records, self.channels))
            self.count += len(records)


def recognises(head: bytes) -> bool:
    """Recognises the format by its magic number."""
    return head.startswith(b"PAR1")


def read(source: Source) -> Iterator[LogBatch]:
    """Yield a batch for each row group, or for a whole file of a trace. Raises BadLog for another
    table or a cut file."""
    file, about = open_parquet(source.path, source.file)
    source.dated, source.start_ns = about["dated"], about.get("start_ns")
    source.clock = about.get("clock", "")
    if "order" in about and ROW in file.schema_arrow.names:
        yield from _sorted(source, file, str(about["order"]))
    else:
        yield from (batch for batch, _, _ in _groups(source, file, list(COLUMNS)))


def open_parquet(path: str, file: Any) -> tuple[Any, dict[str, Any]]:
    """Return the file and its facts, at least "dated"; raises BadLog for an incomplete file, or another table."""
    arrow = load_pyarrow()
    try:
        opened = arrow.parquet.ParquetFile(file, page_checksum_verification=True)
    except (arrow.ArrowException, OSError, UnicodeDecodeError) as error:
        raise BadLog(f"{path}: no whole Parquet file ({error}); its recorder may have been killed") from None
    try:
        names, about = opened.schema_arrow.names, _about(opened)
    except (ValueError, RecursionError) as error:
        raise BadLog(f"{path}: its description is damaged: {error}") from None
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise BadLog(f"{path}: a table without {', '.join(missing)}: no log of canwire")
    plain = [name for name in _WORDS if opened.schema_arrow.field(name).type == arrow.string()]
    if plain:  # others write no dictionaries
        opened = arrow.parquet.ParquetFile(file, read_dictionary=plain, page_checksum_verification=True)
    return opened, {**about, "dated": about["dated"] if "dated" in about else _by_its_times(opened)}


def _about(opened: Any) -> dict[str, Any]:
    about = json.loads((opened.schema_arrow.metadata or {}).get(ABOUT, b"{}"))
    if not isinstance(about, dict):
        raise ValueError("no JSON object")
    return about


def _by_its_times(opened: Any) -> bool:
    """Whether times are dates, judged by the first time, for a file of another program without this fact."""
    if not opened.metadata.num_row_groups:
        return False
    column = opened.metadata.row_group(0).column(opened.schema_arrow.names.index("time_ns"))
    return column.statistics is not None and (column.statistics.min or 0) >= DATED_NS


def _sorted(source: Source, file: Any, order: str) -> Iterator[LogBatch]:
    """Return all rows of a trace's file in the order of recording."""
    numpy = load_numpy()
    groups, rows = [], []
    for batch, kept, table in _groups(source, file, [*COLUMNS, ROW]):
        groups.append(batch.records)
        rows.append(table.column(ROW).to_numpy(zero_copy_only=False)[kept])
    if groups:
        whole = LogBatch(numpy.concatenate(groups), source.channels)
        groups.clear()
        yield in_order(whole, numpy.concatenate(rows), order)


def _groups(source: Source, file: Any, names: list[str]) -> Iterator[tuple[LogBatch, numpy.ndarray, Any]]:
    """Yield records, the places of their rows, and these rows; unreadable row groups are left out."""
    arrow = load_pyarrow()
    groups = file.iter_batches(ROW_GROUP, columns=names)
    before = 0
    while True:
        try:
            batch = next(groups, None)
        except (arrow.ArrowException, OSError, UnicodeDecodeError) as error:
            source.fault(f"row {before}", f"nothing from here on: {' '.join(str(error).split())}")
            return
        if batch is None:
            return
        try:
            records, kept = batch_of_table(source, batch, before)
        except (
            arrow.ArrowException,
            UnicodeDecodeError,
        ) as error:  # indices and texts are not checked before
            source.fault(f"row {before}", f"nothing of these {batch.num_rows} rows: {error}")
            continue
        yield records, kept, batch
        before += batch.num_rows
