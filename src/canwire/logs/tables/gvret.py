"""Writes SavvyCAN's CSV (GVRET): `1500000,00000123,false,Rx,0,2,11,22,`. The format `csv` reads it.

The stamp is in microseconds, and the columns from the seventh on are data. Source: SavvyCAN's examples.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from canwire.logs.entry import LogKind
from canwire.logs.form import FormWriter
from canwire.logs.tables.columns import Row, rows_of
from canwire.logs.tables.csv.reading import read
from canwire.logs.tables.foreign import left_out_of_all
from canwire.values.record import REMOTE

if TYPE_CHECKING:
    import numpy

__all__ = ["Writer", "read", "recognises"]

_HEADER = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n"
_DIRECTIONS = {"R": "Rx", "T": "Tx", None: "Rx"}


class Writer(FormWriter):
    """Rows below a header line; buses have numbers."""

    holds: ClassVar[frozenset[LogKind]] = frozenset((LogKind.CAN_FRAME,))

    def begin(self) -> None:
        self.out(_HEADER.encode())

    def put(self, records: numpy.ndarray) -> None:
        remote = records["info"] & REMOTE != 0
        if remote.any():
            self.leave_out("remote frames", int(remote.sum()))
            records = records[~remote]
        left_out_of_all(self, records, "CAN FD flags (data of more than 8 bytes tell)")
        for what, wrong in (
            ("time stamps' nanoseconds below a microsecond", records["time_ns"] % 1000 != 0),
            ("directions that are not known (Rx is written)", records["direction"] == 0),
        ):
            if count := int(wrong.sum()):
                self.leave_out(what, count)
        buses = {name: number for number, name in enumerate(self.channels)}
        if any(name != f"can{number}" for name, number in buses.items()):
            self.left_out["names of channels (they have numbers)"] = len(buses)
        rows = rows_of(records, self.channels)
        self.out("".join(_line(row, buses[row.channel]) for row in rows).encode(), len(rows))


def recognises(head: bytes) -> bool:
    """Return False: the format `csv` reads these files."""
    del head
    return False


def _line(row: Row, bus: int) -> str:
    extended = "true" if row.extended else "false"
    head = (
        f"{row.time_ns // 1000},{row.id:08X},{extended},{_DIRECTIONS[row.direction]},{bus},{len(row.data)},"
    )
    return head + "".join(f"{byte:02X}," for byte in row.data) + "\n"
