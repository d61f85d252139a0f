"""The functions that decode signals for DuckDB, some thousand frames at a time, by databases/columns.py."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from canwire.databases.columns import decode_signal
from canwire.databases.description import MessageDescription, SignalDescription
from canwire.logs.tables.arrow import load_pyarrow
from canwire.values.dlc import FD_LENGTHS
from canwire.values.record import DLC_SHIFT, EXTENDED_DATA_LENGTH, load_numpy, record_dtype

if TYPE_CHECKING:
    import numpy


class SignalFunctions:
    """`signal_value(number, data)` and `signal_text(number, data)`, where `number` is an index into `signals`."""

    def __init__(self, messages: Sequence[MessageDescription]) -> None:
        self.signals = [(message, signal) for message in messages for signal in message.signals.values()]

    def register(self, connection: Any) -> None:
        """Register the functions on this DuckDB connection."""
        for name, kind, work in (
            ("signal_value", "DOUBLE", self._values),
            ("signal_text", "VARCHAR", self._texts),
        ):
            connection.create_function(
                name, work, ["INTEGER", "BLOB"], kind, type="arrow", null_handling="special",
                side_effects=True,  # else what is filtered by it is computed twice
            )  # fmt: skip

    def _values(self, numbers: Any, data: Any) -> Any:
        """Return physical values, by numbers of signals and data of frames; null if the signal is not in the frame."""
        numpy, arrow = load_numpy(), load_pyarrow()
        found = numpy.empty(len(data), "f8")
        missing = numpy.zeros(len(data), bool)
        for rows, (message, signal), records in self._groups(numbers, data):
            values, present, _ = decode_signal(records, message, signal.name)
            found[rows] = values.astype("f8")
            if present is not None:
                missing[rows] = ~present
        return arrow.array(found, mask=missing)

    def _texts(self, numbers: Any, data: Any) -> Any:
        """Return the texts of signals' values, by numbers of signals and data of frames; null for values without a
        text."""
        numpy, arrow = load_numpy(), load_pyarrow()
        found = numpy.full(len(data), None, object)
        for rows, (message, signal), records in self._groups(numbers, data):
            _, _, raw = decode_signal(records, message, signal.name)
            texts = found[rows]
            for value, text in signal.choices.items():
                texts[raw == value] = text
            found[rows] = texts
        return arrow.array(found, arrow.string())

    def _groups(
        self, numbers: Any, data: Any
    ) -> Iterator[tuple[Any, tuple[MessageDescription, SignalDescription], numpy.ndarray]]:
        """Yield for each signal among the numbers the rows, its description, and the rows' data as records."""
        numpy = load_numpy()
        wanted = numbers.to_numpy()
        records = records_of_data(data.combine_chunks() if hasattr(data, "chunks") else data)
        if len(wanted) and (wanted == wanted[0]).all():
            yield slice(None), self.signals[int(wanted[0])], records
            return
        for number in numpy.unique(wanted).tolist():
            rows = numpy.flatnonzero(wanted == number)
            yield rows, self.signals[number], records[rows]


def records_of_data(data: Any) -> numpy.ndarray:
    """`record_dtype()` records of data frames with these data (an Arrow array of binary values)."""
    numpy = load_numpy()
    records = numpy.zeros(len(data), record_dtype())
    if not len(data):
        return records
    offsets = numpy.frombuffer(data.buffers()[1], "<i4")[data.offset : data.offset + len(data) + 1]
    values = numpy.frombuffer(data.buffers()[2] or b"", "u1")[offsets[0] : offsets[-1]]
    lengths = numpy.diff(offsets)
    first = int(lengths[0])
    if (lengths == first).all():
        records["data"][:, :first] = values.reshape(len(data), first)
    else:
        records["data"][numpy.arange(64) < lengths[:, None]] = values
    codes = numpy.searchsorted(numpy.array(FD_LENGTHS), lengths).astype("u4")
    records["info"] = codes << numpy.uint32(DLC_SHIFT) | numpy.where(
        lengths > 8, numpy.uint32(EXTENDED_DATA_LENGTH), numpy.uint32(0)
    )
    return records
