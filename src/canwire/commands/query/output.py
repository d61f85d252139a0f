"""Writes the rows of a query as a text table, CSV, JSON or a file, some thousand rows at a time."""

from __future__ import annotations

import csv
import json
import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from datetime import date, datetime, time, timedelta
from decimal import Decimal
from itertools import islice
from pathlib import Path
from typing import Any, TextIO

from canwire import BadValue

_AT_ONCE = 2048
_LOOKED_AT = 200  # rows that tell how wide a table's columns are
FORMS = {".csv": "csv", ".json": "json", ".parquet": "parquet"}


def write_rows(rows: Any, form: str, path: str | None) -> None:
    """Print a DuckDB relation, or write it to a file in the format of its suffix.

    An existing file is replaced only when the new one is complete. Raises BadValue, OSError.
    """
    if path is None:
        _WRITERS[form](rows.columns, _values(rows), sys.stdout)
        return
    form = FORMS.get(Path(path).suffix.lower(), "")
    if not form:
        raise BadValue(f"-o {path}: a file that ends with {', '.join(FORMS)}")
    made = f"{path}.new"
    try:
        with open(made, "w", newline="", encoding="utf-8") as file:  # says what would be wrong with it
            if form != "parquet":
                _WRITERS[form](rows.columns, _values(rows), file)
        if form == "parquet":
            rows.to_parquet(made, compression="zstd")
        os.replace(made, path)
    except BaseException:
        with suppress(FileNotFoundError):
            os.remove(made)
        raise


def _values(rows: Any) -> Iterator[list[Any]]:
    """Yield rows of numbers, texts and None; times become ISO 8601 with nanoseconds, bytes become hex digits."""
    import pyarrow
    import pyarrow.compute

    for batch in rows.to_arrow_reader(_AT_ONCE):
        columns = []
        for column in batch.columns:
            if pyarrow.types.is_timestamp(column.type):
                column = pyarrow.compute.strftime(column, "%Y-%m-%dT%H:%M:%S")
            columns.append([_plain(value) for value in column.to_pylist()])
        yield from map(list, zip(*columns, strict=True))


def _plain(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.hex().upper()
    if isinstance(value, dict):
        return {str(name): _plain(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, Decimal):
        return int(value) if value == value.to_integral_value() else float(value)
    if isinstance(value, datetime | date | time):
        return value.isoformat()
    if isinstance(value, timedelta):
        return value.total_seconds()
    return value


def _csv(names: Sequence[str], rows: Iterable[list[Any]], file: TextIO) -> None:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([_text(value) for value in row] for row in rows)


def _json(names: Sequence[str], rows: Iterable[list[Any]], file: TextIO) -> None:
    for row in rows:
        told = {name: _finite(value) for name, value in zip(names, row, strict=True)}
        file.write(json.dumps(told, ensure_ascii=False, default=str) + "\n")


def _table(names: Sequence[str], rows: Iterable[list[Any]], file: TextIO) -> None:
    """Write a table whose columns are as wide as the first rows need; numbers are aligned to the right."""
    shown, numbers = [], [True] * len(names)
    rest = iter(rows)
    for row in islice(rest, _LOOKED_AT):
        numbers = [old and _to_the_right(value) for old, value in zip(numbers, row, strict=True)]
        shown.append([_text(value) for value in row])
    widths = [max(map(len, column)) for column in zip(names, *shown, strict=True)]

    def line(values: Sequence[str]) -> str:
        cells = [
            value.rjust(width) if number else value.ljust(width)
            for value, width, number in zip(values, widths, numbers, strict=True)
        ]
        return "  ".join(cells).rstrip() + "\n"

    file.write(line(names))
    file.writelines(line(row) for row in shown)
    file.writelines(line([_text(value) for value in row]) for row in rest)


def _to_the_right(value: Any) -> bool:
    return value is None or (isinstance(value, int | float) and not isinstance(value, bool))


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return (
        json.dumps(value, ensure_ascii=False, default=str) if isinstance(value, dict | list) else str(value)
    )


def _finite(value: Any) -> Any:
    """Return the value; None for an infinite number or NaN, which JSON cannot represent."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


_WRITERS: dict[str, Callable[[Sequence[str], Iterable[list[Any]], TextIO], None]] = {
    "csv": _csv,
    "json": _json,
    "table": _table,
}
