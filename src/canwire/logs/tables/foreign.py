"""Entries as rows of other programs' tables, which hold less than canwire's: data that they cannot hold are counted."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from canwire.logs.batch import LOG_RECORD_SIZE, entry_of
from canwire.logs.entry import LogKind
from canwire.logs.form import FormWriter
from canwire.logs.tables.columns import rows_of
from canwire.values.error_frame import encode_error_frame
from canwire.values.event import BusEvent
from canwire.values.record import EXTENDED_DATA_LENGTH

if TYPE_CHECKING:
    import numpy

FRAMES_AND_ERRORS = frozenset((LogKind.CAN_FRAME, LogKind.CAN_EVENT))


class PythonCanRow(NamedTuple):
    """A row of python-can's CSV and SQLite; `error` rows have SocketCAN's classes as identifier."""

    time_ns: int
    id: int
    extended: int
    remote: int
    error: int
    length: int
    data: bytes


def python_can_rows(writer: FormWriter, records: numpy.ndarray) -> list[PythonCanRow]:
    """Return rows for these frames and events; python-can's tables hold no channels, directions or CAN FD flags."""
    left_out_of_all(writer, records, "CAN FD flags (data of more than 8 bytes tell)")
    if count := int((records["direction"] != 0).sum()):
        writer.leave_out("directions", count)
    if writer.channels != ["can0"]:
        writer.left_out["names of channels"] = len(writer.channels)
    if count := int((records["time_ns"] % 1000 != 0).sum()):
        writer.leave_out("time stamps' nanoseconds below a microsecond", count)
    stored = records.tobytes()
    found = []
    for at, row in enumerate(rows_of(records, writer.channels)):
        if row.id is None:
            entry = entry_of(stored[at * LOG_RECORD_SIZE : (at + 1) * LOG_RECORD_SIZE], writer.channels)
            assert isinstance(entry.content, BusEvent)
            id, data = encode_error_frame(entry.content)
            found.append(PythonCanRow(row.time_ns, id & 0x1FFF_FFFF, 0, 0, 1, len(data), data))
        else:
            length = row.dlc if row.remote and row.dlc is not None else len(row.data)
            found.append(PythonCanRow(row.time_ns, row.id, row.extended, row.remote, 0, length, row.data))
    return found


def left_out_of_all(writer: FormWriter, records: numpy.ndarray, flags: str) -> None:
    """Count FD frames, whose flags the table cannot hold."""
    is_fd = (records["kind"] == LogKind.CAN_FRAME) & (records["info"] & EXTENDED_DATA_LENGTH != 0)
    if count := int(is_fd.sum()):
        writer.leave_out(flags, count)
