"""Writes CSV: a header line, and a row for each entry."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from canwire.logs.entry import LogKind
from canwire.logs.form import FormWriter
from canwire.logs.tables.columns import Row, rows_of
from canwire.logs.tables.csv.rows import HEADER

if TYPE_CHECKING:
    import numpy

_PIECE = 4096


class Writer(FormWriter):
    """Rows below a header line."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)

    def begin(self) -> None:
        self.out(f"{HEADER}\n".encode())

    def put(self, records: numpy.ndarray) -> None:
        for at in range(0, len(records), _PIECE):
            rows = rows_of(records[at : at + _PIECE], self.channels)
            self.out("".join(map(_line, rows)).encode(), len(rows))


def _line(row: Row) -> str:
    seconds, rest = divmod(row.time_ns, 10**9)
    id = "" if row.id is None else f"{row.id:08X}" if row.extended else f"{row.id:X}"
    detail = '"' + row.detail.replace('"', '""') + '"' if row.detail else ""
    dlc = "" if row.dlc is None else row.dlc
    return (
        f"{seconds}.{rest:09d},{_quoted(row.channel)},{row.direction or ''},{row.type},{id},{row.extended},"
        f"{row.remote},{row.fd},{row.brs},{row.esi},{dlc},{row.data.hex().upper()},{detail}\n"
    )


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if any(one in text for one in ',"\r\n') else text
