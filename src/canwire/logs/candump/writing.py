"""Writes candump logs. Plain frames are laid out as columns of bytes, and a mask removes the columns that a line
lacks.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar

from canwire.logs.batch import LOG_RECORD_SIZE, entry_of
from canwire.logs.entry import LogEntry, LogKind, LogMark, MarkKind
from canwire.logs.form import FormWriter
from canwire.values.event import BusEvent, ErrorKind, EventKind
from canwire.values.lin.event import LinEvent
from canwire.values.lin.frame import LinFrame
from canwire.values.lin.text import LinLogLine, format_lin_log_line
from canwire.values.record import (
    DLC_SHIFT,
    EXTENDED,
    EXTENDED_DATA_LENGTH,
    REMOTE,
    load_numpy,
)
from canwire.values.text import LogLine, format_log_line

if TYPE_CHECKING:
    import numpy

_PIECE = 8192  # records laid out together: the columns stay in the cache


class Writer(FormWriter):
    """Lines as `candump -L -x` prints them. A count of lost frames becomes an error frame (receive overflow)."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)

    def put(self, records: numpy.ndarray) -> None:
        numpy = load_numpy()
        if fine := int((records["time_ns"] % 1000 != 0).sum()):
            self.leave_out("time stamps' nanoseconds below a microsecond", fine)
        info = records["info"]
        odd = (records["kind"] != LogKind.CAN_FRAME) | (info & (REMOTE | EXTENDED_DATA_LENGTH) != 0)
        odd |= (info >> DLC_SHIFT & 15) > 8
        edges = numpy.flatnonzero(numpy.diff(odd)) + 1
        for part in numpy.split(records, edges) if len(edges) else [records]:
            if odd[0]:
                self._put_singly(part)
            else:
                for at in range(0, len(part), _PIECE):
                    piece = part[at : at + _PIECE]
                    self.out(_laid_out(piece, self.channels), len(piece))
            odd = odd[len(part) :]

    def _put_singly(self, records: numpy.ndarray) -> None:
        block = records.tobytes()
        for at in range(0, len(block), LOG_RECORD_SIZE):
            text = self._line(entry_of(block[at : at + LOG_RECORD_SIZE], self.channels))
            if text:
                self.out(f"{text}\n".encode(), 1)

    def _line(self, entry: LogEntry) -> str:
        time_ns, channel, content, direction = entry
        channel = _name(channel)
        if isinstance(content, LogMark):
            if content.kind is not MarkKind.LOST:
                self.leave_out(f"{content.kind.name.lower().replace('_', ' ')} marks", 1)
                return ""
            self.leave_out("numbers of lost frames (each place has an error frame, receive overflow)", 1)
            content = BusEvent(EventKind.OVERRUN, time_ns)
        if isinstance(content, LinFrame | LinEvent):
            return format_lin_log_line(LinLogLine(time_ns, channel, content, direction))
        if isinstance(content, BusEvent) and (content.bit >= 0 or content.error is ErrorKind.FAST_DATA_BIT):
            self.leave_out("details of error frames (bit position)", 1)
        return format_log_line(LogLine(time_ns, channel, content, direction))


def _name(channel: str) -> str:
    """A channel's name as one word, which lines need."""
    return "".join("_" if one.isspace() or one in "()" else one for one in channel) or "can0"


def _laid_out(records: numpy.ndarray, channels: list[str]) -> bytes:
    """Return plain classic data frames as lines."""
    numpy = load_numpy()
    names = [_name(name).encode() for name in channels]
    widest = max(map(len, names))
    count = len(records)
    micros = records["time_ns"] // numpy.uint64(1000)
    digits = max(10, len(str(int(micros.max()) // 10**6)))
    line = numpy.zeros((count, digits + 10 + widest + 29), numpy.uint8)
    line[:, 0] = 40
    _put_decimals(line[:, digits + 2 : digits + 8], micros % numpy.uint64(10**6))
    _put_decimals(line[:, 1 : digits + 1], micros // numpy.uint64(10**6))
    line[:, digits + 1], line[:, digits + 8], line[:, digits + 9] = 46, 41, 32
    at = digits + 10
    table = numpy.frombuffer(b"".join(name.ljust(widest, b"\0") for name in names), "u1").reshape(-1, widest)
    line[:, at : at + widest] = table[records["channel"]]
    _put_frames(line[:, at + widest :], records)
    return line[line != 0].tobytes()


def _put_decimals(columns: Any, values: Any) -> None:
    """Write numbers as decimal digits, with leading zeros."""
    numpy = load_numpy()
    for column in range(columns.shape[1] - 1, -1, -1):
        rest = values // numpy.uint64(10)
        columns[:, column] = values - rest * numpy.uint64(10) + numpy.uint64(48)
        values = rest


def _put_frames(line: Any, records: numpy.ndarray) -> None:
    """Write ` ID#DATA D` and the end of the line; unused columns stay 0."""
    numpy = load_numpy()
    pairs = _pairs()
    extended = records["info"] & EXTENDED != 0
    identifiers = pairs[records["id"].astype(">u4").view("u1").reshape(-1, 4)].reshape(-1, 8)
    identifiers[~extended, :5] = 0
    line[:, 0] = 32
    line[:, 1:9] = identifiers
    line[:, 9] = 35
    length = records["info"] >> DLC_SHIFT & 15
    data = pairs[records["data"][:, :8]].reshape(-1, 16)
    data[numpy.arange(16) >= (2 * length)[:, None]] = 0
    line[:, 10:26] = data
    known = records["direction"] != 0
    line[known, 26] = 32
    line[:, 27] = numpy.array([0, 82, 84], "u1")[records["direction"]]
    line[:, 28] = 10


@cache
def _pairs() -> Any:
    """The two hex characters of every byte."""
    numpy = load_numpy()
    return numpy.frombuffer(bytes(range(256)).hex().upper().encode(), "u1").reshape(256, 2)
