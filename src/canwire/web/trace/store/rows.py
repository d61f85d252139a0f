"""A row of a trace: a record of 80 bytes (values/record.py), the line's index, flags, the colour that a viewer's rules
give it, and the low 32 bits of its number. Rows that say what is missing have kinds that no record of a hub's has."""

from __future__ import annotations

from functools import cache

import numpy

from canwire import record_dtype

ROW_BYTES = 88
# kinds of rows that are no record of the hub's: the hub was away; records were lost; nobody listened; rows are gone
GAP, LOST, UNHEARD, GONE = 0xF0, 0xF1, 0xF2, 0xF3
LATE = 1  # a flag: it came after rows with a later stamp had their numbers
EVERY_LINE = 0xFFFF  # the line of a row that is about all of them
_NO_ID = 0xFFFFFFFF


@cache
def row_dtype() -> numpy.dtype[numpy.void]:
    """Return the numpy dtype of a row: record, line, flags, colour, number."""
    return numpy.dtype(
        {
            "names": ["record", "line", "flags", "colour", "number"],
            "formats": [record_dtype(), "<u2", "u1", "u1", "<u4"],
            "offsets": [0, 80, 82, 83, 84],
            "itemsize": ROW_BYTES,
        }
    )


def rows_of(records: numpy.ndarray, line: int) -> numpy.ndarray:
    """Convert records of one line to rows without numbers."""
    rows = numpy.zeros(len(records), row_dtype())
    rows["record"] = records
    rows["line"] = line
    return rows


def mark_row(kind: int, line: int, count: int, time_ns: int) -> numpy.ndarray:
    """Return a row that reports missing data: GAP and UNHEARD with milliseconds, LOST and GONE with records."""
    row = numpy.zeros(1, row_dtype())
    row["record"]["time_ns"] = time_ns
    row["record"]["id"] = _NO_ID
    row["record"]["info"] = kind
    row["record"]["data"][0, :8] = numpy.frombuffer(count.to_bytes(8, "little"), numpy.uint8)
    row["line"] = line
    return row
