"""Parquet: the columns of columns.py, built from records without a loop. Needs canwire[parquet]."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, ClassVar

from canwire.errors import BadFrame, BadLog, BadText, ExtraMissing
from canwire.logs.batch import DIRECTIONS, LogBatch, log_dtype
from canwire.logs.entry import LogKind
from canwire.logs.form import FormWriter
from canwire.logs.source import Source
from canwire.logs.tables.columns import COLUMNS, FLAGS, Row, lengths_of, rows_of
from canwire.values.record import DLC_SHIFT, EXTENDED_DATA_LENGTH, load_numpy

if TYPE_CHECKING:
    import numpy

ROW_GROUP = 1 << 17
_ABOUT = b"canwire"
_TYPES = tuple(LogKind.__members__)


class Writer(FormWriter):
    """Row groups of some 100,000 entries, compressed with zstd; readable once it is closed."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)
    opens: ClassVar[bool] = True
    needs_end: ClassVar[bool] = True

    def begin(self) -> None:
        self._arrow = _pyarrow()
        about = {"version": 1, "dated": self.dated, "start_ns": self.start_ns, "clock": self.clock}
        schema = _schema(self._arrow).with_metadata({_ABOUT: json.dumps(about).encode()})
        self._sink = self._arrow.parquet.ParquetWriter(self.file, schema, compression="zstd")
        self._schema = schema
        self._parts: list[Any] = []
        self._held = 0

    def put(self, records: numpy.ndarray) -> None:
        self._parts.append(records)
        self._held += len(records)
        if self._held >= ROW_GROUP:
            self._put_group()

    def sync(self) -> None:
        """Nothing: the file means something at its end only."""

    def end(self) -> None:
        try:
            self._put_group()
        finally:
            self._sink.close()

    def _put_group(self) -> None:
        if self._held:
            records = load_numpy().concatenate(self._parts)
            self._parts, self._held = [], 0
            self._sink.write_table(_table(self._arrow, self._schema, records, self.channels))
            self.count += len(records)


def recognises(head: bytes) -> bool:
    """By its magic number."""
    return head.startswith(b"PAR1")


def read(source: Source) -> Iterator[LogBatch]:
    """Row group by row group. Raises BadLog for another table, and for a file that was not closed."""
    arrow = _pyarrow()
    try:
        file = arrow.parquet.ParquetFile(source.file)
    except (arrow.ArrowException, OSError) as error:
        raise BadLog(
            f"{source.path}: no whole Parquet file ({error}); its recorder may have been killed"
        ) from None
    missing = [name for name in COLUMNS if name not in file.schema_arrow.names]
    if missing:
        raise BadLog(f"{source.path}: a table without {', '.join(missing)}: no log of canwire")
    about = json.loads((file.schema_arrow.metadata or {}).get(_ABOUT, b"{}"))
    source.dated, source.start_ns = bool(about.get("dated")), about.get("start_ns")
    source.clock = about.get("clock", "")
    groups = file.iter_batches(ROW_GROUP, columns=list(COLUMNS))
    while True:
        try:
            batch = next(groups, None)
        except (arrow.ArrowException, OSError) as error:
            source.fault("row group", str(error))
            return
        if batch is None:
            return
        yield _batch(source, batch)


def _pyarrow() -> Any:
    try:
        import pyarrow
        import pyarrow.parquet
    except ModuleNotFoundError:
        raise ExtraMissing("pyarrow", "parquet") from None
    return pyarrow


def _schema(arrow: Any) -> Any:
    word = arrow.dictionary(arrow.int32(), arrow.string())
    types = {"time_ns": arrow.int64(), "channel": word, "direction": word, "type": word, "id": arrow.uint32(),
             "dlc": arrow.uint8(), "data": arrow.binary(), "detail": arrow.string()}  # fmt: skip
    return arrow.schema([(name, types.get(name, arrow.bool_())) for name in COLUMNS])


def _table(arrow: Any, schema: Any, records: numpy.ndarray, channels: list[str]) -> Any:
    numpy = load_numpy()
    info = records["info"]
    is_frame = records["kind"] == LogKind.CAN_FRAME
    lengths = numpy.where(is_frame, lengths_of(records), 0)
    direction = records["direction"].astype("i4")
    columns = {
        "time_ns": arrow.array(records["time_ns"].astype("i8")),
        "channel": _words(arrow, records["channel"].astype("i4"), channels),
        "direction": arrow.DictionaryArray.from_arrays(
            arrow.array(direction - 1, mask=direction == 0), list(DIRECTIONS[1:])
        ),
        "type": _words(arrow, records["kind"].astype("i4"), list(_TYPES)),
        "id": arrow.array(records["id"], mask=~is_frame),
        **{name: arrow.array(is_frame & (info & bit != 0)) for name, bit in FLAGS.items()},
        "dlc": arrow.array((info >> DLC_SHIFT & 15).astype("u1"), mask=~is_frame),
        "data": _bytes(arrow, records["data"], lengths),
        "detail": arrow.nulls(len(records), arrow.string()),
    }
    others = numpy.flatnonzero(~is_frame)
    if len(others):
        rows = rows_of(records[others], channels)
        for name in ("id", "dlc", "data", "detail"):
            values = columns[name].to_pylist()
            for number, row in zip(others.tolist(), rows, strict=True):
                values[number] = getattr(row, name)
            columns[name] = arrow.array(values, schema.field(name).type)
    return arrow.table([columns[name] for name in COLUMNS], schema=schema)


def _words(arrow: Any, indices: Any, words: list[str]) -> Any:
    return arrow.DictionaryArray.from_arrays(arrow.array(indices), words)


def _bytes(arrow: Any, data: Any, lengths: Any) -> Any:
    """The data as binary values of these lengths."""
    numpy = load_numpy()
    offsets = numpy.zeros(len(lengths) + 1, "<i4")
    numpy.cumsum(lengths, out=offsets[1:])
    used = data[numpy.arange(64) < lengths[:, None]]
    buffers = [None, arrow.py_buffer(offsets), arrow.py_buffer(numpy.ascontiguousarray(used))]
    return arrow.Array.from_buffers(arrow.binary(), len(lengths), buffers)


def _batch(source: Source, batch: Any) -> LogBatch:
    numpy = load_numpy()
    kinds = numpy.asarray(batch.column("type").dictionary_decode().to_numpy(zero_copy_only=False))
    records = _frames(source, batch)
    others = numpy.flatnonzero(kinds != "CAN_FRAME")
    bad = numpy.flatnonzero((kinds == "CAN_FRAME") & ~_fit(records, batch))
    keep = numpy.ones(len(records), bool)
    for number in sorted({*others.tolist(), *bad.tolist()}):
        values = {name: batch.column(name)[number].as_py() for name in COLUMNS}
        try:
            row = Row(**values)
            entry = row._replace(detail=row.detail or "", data=row.data or b"").entry()
            records[number : number + 1] = source.batch([entry]).records
        except (BadFrame, BadText) as error:
            source.fault(f"row {number}", str(error))
            keep[number] = False
    return LogBatch(records[keep], source.channels)


def _frames(source: Source, batch: Any) -> numpy.ndarray:
    """Records of all rows as if they were CAN frames."""
    numpy = load_numpy()
    records = numpy.zeros(batch.num_rows, log_dtype())
    records["time_ns"] = batch.column("time_ns").to_numpy().astype("u8")
    records["id"] = batch.column("id").fill_null(0).to_numpy(zero_copy_only=False)
    names = batch.column("channel")
    numbers = [source.channel(name) for name in names.dictionary.to_pylist()]
    records["channel"] = numpy.array(numbers, "u2")[names.indices.to_numpy()]
    directions = batch.column("direction").dictionary_decode().to_numpy(zero_copy_only=False)
    records["direction"] = (directions == "R") + 2 * (directions == "T")
    info = batch.column("dlc").fill_null(0).to_numpy(zero_copy_only=False).astype("u4") << DLC_SHIFT
    for name, bit in FLAGS.items():
        info |= numpy.where(batch.column(name).to_numpy(zero_copy_only=False), bit, 0).astype("u4")
    records["info"] = info
    lengths, values = _data(batch)
    keep = numpy.arange(64) < numpy.minimum(lengths, 64)[:, None]
    if int(lengths.max(initial=0)) <= 64:
        records["data"][keep] = values
    return records


def _data(batch: Any) -> tuple[Any, Any]:
    """How long each row's data are, and all of them in a row."""
    numpy = load_numpy()
    data = batch.column("data")
    offsets = numpy.frombuffer(data.buffers()[1], "<i4")[data.offset : data.offset + len(data) + 1]
    values = numpy.frombuffer(data.buffers()[2] or b"", "u1")[offsets[0] : offsets[-1]]
    return numpy.diff(offsets), values


def _fit(records: numpy.ndarray, batch: Any) -> Any:
    """Which rows are CAN frames that could be: others are looked at one by one, and say what is wrong."""
    numpy = load_numpy()
    lengths, _ = _data(batch)
    info = records["info"]
    extended = info & FLAGS["extended"] != 0
    fd = info & EXTENDED_DATA_LENGTH != 0
    fit = records["id"] <= numpy.where(extended, 0x1FFF_FFFF, 0x7FF)
    fit &= lengths == lengths_of(records)
    fit &= ~(fd & (info & FLAGS["remote"] != 0))
    return fit & (fd | (info & (FLAGS["brs"] | FLAGS["esi"]) == 0))
