"""The columns of columns.py as Arrow columns, converted from and to records without a loop. Needs canwire[parquet]."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from canwire.errors import BadFrame, BadText, ExtraMissing
from canwire.logs.batch import DIRECTIONS, LogBatch, batch_of, log_dtype
from canwire.logs.entry import LogEntry, LogKind
from canwire.logs.source import Source
from canwire.logs.tables.columns import COLUMNS, FLAGS, Row, lengths_of, rows_of
from canwire.values.record import DLC_SHIFT, EXTENDED_DATA_LENGTH, load_numpy

if TYPE_CHECKING:
    import numpy

# pandas makes floating-point numbers of integers that may be missing, unless these columns are declared
_COLUMNS = [
    {"name": name, "field_name": name, "pandas_type": kind.lower(), "numpy_type": kind, "metadata": None}
    for name, kind in (("id", "UInt32"), ("dlc", "UInt8"))
]
_ABOUT = {"index_columns": [], "column_indexes": [], "columns": _COLUMNS, "pandas_version": "2.0"}
FOR_PANDAS = {b"pandas": json.dumps(_ABOUT).encode()}
"""Metadata of a file of these columns."""

_TYPES = tuple(LogKind.__members__)


def load_pyarrow() -> Any:
    """pyarrow with its Parquet and functions; raises ExtraMissing."""
    try:
        import pyarrow
        import pyarrow.compute
        import pyarrow.parquet
    except ModuleNotFoundError:
        raise ExtraMissing("pyarrow", "parquet") from None
    return pyarrow


def schema_of_log(arrow: Any) -> Any:
    """Return the types of the columns."""
    word = arrow.dictionary(arrow.int32(), arrow.string())
    types = {"time_ns": arrow.int64(), "channel": word, "direction": word, "type": word, "id": arrow.uint32(),
             "dlc": arrow.uint8(), "data": arrow.binary(), "detail": arrow.string()}  # fmt: skip
    return arrow.schema([(name, types.get(name, arrow.bool_())) for name in COLUMNS])


def table_of(arrow: Any, schema: Any, records: numpy.ndarray, channels: list[str]) -> Any:
    """Convert records to a table of the columns in `schema`, in their order."""
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
    others = ~is_frame
    if others.any():
        rows = rows_of(records[others], channels)
        mask = arrow.array(others)
        for name in ("id", "dlc", "data", "detail"):
            values = arrow.array([getattr(row, name) for row in rows], schema.field(name).type)
            columns[name] = arrow.compute.replace_with_mask(columns[name], mask, values)
    return arrow.table([columns[name] for name in COLUMNS], schema=schema)


def _words(arrow: Any, indices: Any, words: list[str]) -> Any:
    return arrow.DictionaryArray.from_arrays(arrow.array(indices), words)


def _bytes(arrow: Any, data: Any, lengths: Any) -> Any:
    """Convert the data to binary values of these lengths."""
    numpy = load_numpy()
    offsets = numpy.zeros(len(lengths) + 1, "<i4")
    numpy.cumsum(lengths, out=offsets[1:])
    most = int(lengths.max(initial=0))
    used = data[:, :most]
    if int(lengths.min(initial=most)) < most:
        used = used[numpy.arange(most) < lengths[:, None]]
    buffers = [None, arrow.py_buffer(offsets), arrow.py_buffer(numpy.ascontiguousarray(used))]
    return arrow.Array.from_buffers(arrow.binary(), len(lengths), buffers)


def batch_of_table(source: Source, batch: Any, before: int = 0) -> tuple[LogBatch, numpy.ndarray]:
    """Convert rows to records; also returns the rows' places. An invalid row is a fault, counted from `before`."""
    numpy = load_numpy()
    kinds = numpy.asarray(batch.column("type").dictionary_decode().to_numpy(zero_copy_only=False))
    records = _frames(source, batch)
    single = numpy.flatnonzero((kinds != "CAN_FRAME") | ~_fit(records, batch))
    keep = numpy.ones(len(records), bool)
    places, entries = [], []
    for place, values in zip(single.tolist(), batch.take(single).to_pylist(), strict=True):
        try:
            entries.append(_entry(values))
            places.append(place)
        except (BadFrame, BadText) as error:
            source.fault(f"row {before + place}", str(error))
            keep[place] = False
    if entries:
        records[places] = batch_of(entries, source.channels).records
    return LogBatch(records[keep], source.channels), keep


def _entry(values: dict[str, Any]) -> LogEntry:
    row = Row(**{name: values[name] for name in COLUMNS})
    return row._replace(detail=row.detail or "", data=row.data or b"").entry()


def _frames(source: Source, batch: Any) -> numpy.ndarray:
    """Convert all rows to records as if they were CAN frames."""
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
    most = int(lengths.max(initial=0))
    if most <= 64:
        records["data"][:, :most][numpy.arange(most) < lengths[:, None]] = values
    return records


def _data(batch: Any) -> tuple[Any, Any]:
    """Return the length of each row's data, and the data of all rows one after the other."""
    numpy = load_numpy()
    data = batch.column("data")
    offsets = numpy.frombuffer(data.buffers()[1], "<i4")[data.offset : data.offset + len(data) + 1]
    values = numpy.frombuffer(data.buffers()[2] or b"", "u1")[offsets[0] : offsets[-1]]
    return numpy.diff(offsets), values


def _fit(records: numpy.ndarray, batch: Any) -> Any:
    """Select the rows that are valid CAN frames; the others are converted one by one, which reports their errors."""
    numpy = load_numpy()
    lengths, _ = _data(batch)
    info = records["info"]
    extended = info & FLAGS["extended"] != 0
    fd = info & EXTENDED_DATA_LENGTH != 0
    fit = records["id"] <= numpy.where(extended, 0x1FFF_FFFF, 0x7FF)
    fit &= lengths == lengths_of(records)
    fit &= ~(fd & (info & FLAGS["remote"] != 0))
    return fit & (fd | (info & (FLAGS["brs"] | FLAGS["esi"]) == 0))
