"""Writes python-can's CSV: `1.5,0x123,0,0,0,2,ESI=`. The format `csv` reads it.

Source: python-can 4.6, can/io/csv.py."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, ClassVar

from canwire.logs.entry import LogKind
from canwire.logs.form import FormWriter
from canwire.logs.tables.csv.reading import read
from canwire.logs.tables.csv.rows import PYTHON_CAN
from canwire.logs.tables.foreign import FRAMES_AND_ERRORS, PythonCanRow, python_can_rows

if TYPE_CHECKING:
    import numpy

__all__ = ["Writer", "read", "recognises"]


class Writer(FormWriter):
    """Rows below a header line."""

    holds: ClassVar[frozenset[LogKind]] = FRAMES_AND_ERRORS

    def begin(self) -> None:
        self.out(f"{PYTHON_CAN}\n".encode())

    def put(self, records: numpy.ndarray) -> None:
        rows = python_can_rows(self, records)
        self.out("".join(map(_line, rows)).encode(), len(rows))


def recognises(head: bytes) -> bool:
    """Return False: the format `csv` reads these files."""
    del head
    return False


def _line(row: PythonCanRow) -> str:
    seconds, rest = divmod(row.time_ns, 10**9)
    data = base64.b64encode(row.data).decode()
    return f"{seconds}.{rest // 1000:06d},{row.id:#x},{row.extended},{row.remote},{row.error},{row.length},{data}\n"
