"""The columns of a log that is a table, from records and to them.

time_ns     nanoseconds since 1970 or since the log's zero (CSV: time_s, seconds with nine decimals)
channel     name of the channel
direction   R, T or nothing
type        CAN_FRAME, CAN_EVENT, LIN_FRAME, LIN_EVENT, MARK
id          identifier, a number (CSV: hex)
extended, remote, fd, brs, esi   0 or 1
dlc         data length code; of a LIN frame its length
data        the bytes (CSV: hex)
detail      of an event, a mark, a LIN frame that is not default: a JSON object, see detail.py
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from canwire.errors import BadText
from canwire.logs.batch import DIRECTIONS, LOG_RECORD_SIZE, entry_of
from canwire.logs.detail import content_of_detail, detail_of, lin_frame_of_detail
from canwire.logs.entry import LogEntry, LogKind
from canwire.values.dlc import FD_LENGTHS
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame
from canwire.values.record import (
    DLC_SHIFT,
    ERROR_STATE_INDICATOR,
    EXTENDED,
    EXTENDED_DATA_LENGTH,
    FAST_DATA_RATE,
    REMOTE,
    load_numpy,
)

if TYPE_CHECKING:
    import numpy

COLUMNS = ("time_ns", "channel", "direction", "type", "id", "extended", "remote", "fd", "brs", "esi", "dlc", "data",
           "detail")  # fmt: skip
FLAGS = {"extended": EXTENDED, "remote": REMOTE, "fd": EXTENDED_DATA_LENGTH, "brs": FAST_DATA_RATE,
         "esi": ERROR_STATE_INDICATOR}  # fmt: skip


class Row(NamedTuple):
    """One entry in columns."""

    time_ns: int
    channel: str
    direction: str | None
    type: str
    id: int | None
    extended: int
    remote: int
    fd: int
    brs: int
    esi: int
    dlc: int | None
    data: bytes
    detail: str

    def entry(self) -> LogEntry:
        """Return the entry; raises BadText, BadFrame for invalid columns."""
        if self.type not in LogKind.__members__:
            raise BadText(f"type {self.type!r}: one of {', '.join(LogKind.__members__)}")
        kind = LogKind[self.type]
        if self.direction not in DIRECTIONS:
            raise BadText(f"direction {self.direction!r}: R, T or nothing")
        return LogEntry(self.time_ns, self.channel, self._content(kind), self.direction)

    def _content(self, kind: LogKind) -> Any:
        if kind is LogKind.CAN_FRAME:
            return self._frame()
        if kind is LogKind.LIN_FRAME:
            sent = self.direction == "T"
            return lin_frame_of_detail(self.detail, self.id or 0, self.data, self.time_ns, sent)
        return content_of_detail(kind, self.detail, self.time_ns)

    def _frame(self) -> Frame:
        if self.id is None:
            raise BadText("a CAN frame without an identifier")
        return Frame(
            self.id,
            self.data,
            extended=bool(self.extended),
            remote=bool(self.remote),
            fd=bool(self.fd),
            bit_rate_switch=bool(self.brs),
            error_state_indicator=bool(self.esi),
            dlc=self.dlc,
            timestamp_ns=self.time_ns,
        )


def lengths_of(records: numpy.ndarray) -> Any:
    """Return the number of data bytes of each CAN frame."""
    numpy = load_numpy()
    info = records["info"]
    is_fd = info & EXTENDED_DATA_LENGTH != 0
    lengths = numpy.array(FD_LENGTHS)[info >> DLC_SHIFT & 15]
    lengths = numpy.where(is_fd, lengths, numpy.minimum(lengths, 8))
    lengths[info & REMOTE != 0] = 0
    return lengths


def rows_of(records: numpy.ndarray, channels: list[str]) -> list[Row]:
    """Return a row for each record: CAN frames by columns, other records one by one."""
    numpy = load_numpy()
    info = records["info"]
    block = records["data"].tobytes()
    lengths = lengths_of(records).tolist()
    names = [channels[number] for number in records["channel"].tolist()]
    columns = (
        records["time_ns"].tolist(),
        names,
        [DIRECTIONS[code] for code in records["direction"].tolist()],
        ["CAN_FRAME"] * len(records),
        records["id"].tolist(),
        *((info & bit != 0).astype("u1").tolist() for bit in FLAGS.values()),
        (info >> DLC_SHIFT & 15).tolist(),
        [block[64 * number : 64 * number + length] for number, length in enumerate(lengths)],
        [""] * len(records),
    )
    rows = [*map(Row._make, zip(*columns, strict=True))]
    for number in numpy.flatnonzero(records["kind"] != LogKind.CAN_FRAME).tolist():
        rows[number] = _other_row(
            entry_of(records[number : number + 1].tobytes()[:LOG_RECORD_SIZE], channels)
        )
    return rows


def _other_row(entry: LogEntry) -> Row:
    content = entry.content
    lin = isinstance(content, LinFrame)
    kind = _KIND_NAMES[type(content).__name__]
    id = content.id if isinstance(content, LinFrame) else None
    data = content.data if isinstance(content, LinFrame) else b""
    length = len(data) if lin else None
    detail = detail_of(content)
    return Row(
        entry.timestamp_ns, entry.channel, entry.direction, kind, id, 0, 0, 0, 0, 0, length, data, detail
    )


_KIND_NAMES = {
    "BusEvent": "CAN_EVENT",
    "LinFrame": "LIN_FRAME",
    "LinEvent": "LIN_EVENT",
    "LogMark": "MARK",
}
