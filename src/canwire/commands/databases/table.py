"""Signals as a Parquet table: time_s, time_ns, channel, message, signal, value, text, unit; a row for each value."""

from __future__ import annotations

import os
from collections.abc import Sequence
from importlib import import_module
from types import TracebackType
from typing import Any

from canwire import BadValue, DecodedMessage, ExtraMissing

_AT_ONCE = 100_000
_COLUMNS = {
    "time_s": "float64", "time_ns": "int64", "channel": "string", "message": "string", "signal": "string",
    "value": "float64", "text": "string", "unit": "string",
}  # fmt: skip


class SignalTable:
    """A new file, which gets its name when it is complete; raises ExtraMissing, BadValue for another suffix, OSError.

    A value that a double cannot hold (more than 53 bits, or several numbers in one signal) is written in `text`.
    """

    def __init__(self, path: str) -> None:
        if not path.endswith(".parquet"):
            raise BadValue(f"-o {path}: signals are written to a .parquet file; text goes to standard output")
        try:
            self._arrow = import_module("pyarrow")
            parquet = import_module("pyarrow.parquet")
        except ModuleNotFoundError:
            raise ExtraMissing("pyarrow", "parquet") from None
        self._path = path
        self._made = f"{path}.new-{os.getpid()}"
        kinds = {name: getattr(self._arrow, kind)() for name, kind in _COLUMNS.items()}
        self._schema = self._arrow.schema(list(kinds.items()))
        open(self._made, "wb").close()  # says in the system's words what would be wrong with it
        self._writer: Any = parquet.ParquetWriter(self._made, self._schema)
        self._rows: list[Sequence[Any]] = []
        self.count = 0

    def put(self, time_ns: int, channel: str, message: DecodedMessage) -> None:
        """A row for each of the message's signals."""
        for name, number in message.numbers.items():
            value, text = _said(number, message.signals[name])
            unit = message.description.signals[name].unit
            self._rows.append((time_ns / 1e9, time_ns, channel, message.name, name, value, text, unit))
        if len(self._rows) >= _AT_ONCE:
            self._write()

    def __enter__(self) -> SignalTable:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        """The file as it should be, or as it was."""
        try:
            if kind is None:
                self._write()
            self._writer.close()
            if kind is None:
                os.replace(self._made, self._path)
        finally:
            if os.path.exists(self._made):
                os.remove(self._made)

    def _write(self) -> None:
        rows, self._rows = self._rows, []
        columns = [list(column) for column in zip(*rows, strict=True)] or [[] for _ in _COLUMNS]
        arrays = [
            self._arrow.array(column, field.type) for column, field in zip(columns, self._schema, strict=True)
        ]
        self._writer.write_table(self._arrow.table(arrays, schema=self._schema))
        self.count += len(rows)


def _said(number: Any, signal: Any) -> tuple[float | None, str | None]:
    if not isinstance(number, int | float):
        return None, str(signal)
    exact = isinstance(number, float) or int(float(number)) == number
    text = signal if isinstance(signal, str) else None if exact else str(number)
    return float(number), text
