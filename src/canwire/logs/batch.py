"""Many entries of a log as numpy records: quick to filter, count, convert. Needs canwire[arrays].

A record of `log_dtype()` is a record of a ring (values/record.py: time_ns, id, info, data[64]) followed by
`channel`, an index into the batch's names, `kind`, a LogKind, and `direction`, 0 unknown, 1 received, 2 transmitted.
A MARK has its MarkKind as `id`; its `data` contain the count (8 bytes), both bit rates (4 bytes each) and the text.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import TYPE_CHECKING

from canwire.errors import BadValue
from canwire.logs.entry import Content, LogEntry, LogKind, LogMark, MarkKind
from canwire.values.event import BusEvent
from canwire.values.frame import Frame, frame_of_record, record_of_frame
from canwire.values.lin.event import LinEvent
from canwire.values.lin.frame import LinFrame
from canwire.values.lin.record import lin_frame_of_record, record_of_lin_frame
from canwire.values.record import RECORD_SIZE, SELF_RECEPTION, load_numpy

if TYPE_CHECKING:
    import numpy

LOG_RECORD_SIZE = 88
DIRECTIONS: tuple[str | None, ...] = (None, "R", "T")
_CODES = {direction: code for code, direction in enumerate(DIRECTIONS)}
_MARK = struct.Struct("<QIIQII48s")
_TAIL = struct.Struct("<HBB4x")


@cache
def log_dtype() -> numpy.dtype[numpy.void]:
    """numpy dtype of a log's record, 88 bytes: time_ns, id, info, data[64], channel, kind, direction, reserved."""
    return load_numpy().dtype(
        [("time_ns", "<u8"), ("id", "<u4"), ("info", "<u4"), ("data", "u1", 64), ("channel", "<u2"),
         ("kind", "u1"), ("direction", "u1"), ("reserved", "<u4")]
    )  # fmt: skip


class LogBatch:
    """Some entries of a log, in their order: `records` of `log_dtype()`, and the names that `channel` indexes.

    `channels` is the log's own list, which grows while the log is read; indices stay valid.
    """

    __slots__ = ("channels", "records")

    def __init__(self, records: numpy.ndarray, channels: list[str]) -> None:
        self.records = records
        self.channels = channels

    def __repr__(self) -> str:
        return f"<LogBatch of {len(self)} entries, channels {', '.join(self.channels)}>"

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[LogEntry]:
        """Yield the entries one by one; raises BadValue or BadFrame for an invalid record."""
        block, size = self.records.tobytes(), LOG_RECORD_SIZE
        for at in range(0, len(block), size):
            yield entry_of(block[at : at + size], self.channels)

    @property
    def frames(self) -> numpy.ndarray:
        """The records that are CAN frames."""
        return self.records[self.records["kind"] == LogKind.CAN_FRAME]


def batch_of(entries: Iterable[LogEntry], channels: list[str]) -> LogBatch:
    """Entries as a batch; names missing in `channels` are appended to it. Raises BadValue for other objects."""
    index = {name: number for number, name in enumerate(channels)}
    blocks = []
    for entry in entries:
        number = index.get(entry.channel)
        if number is None:
            number = index[entry.channel] = len(channels)
            channels.append(entry.channel)
        blocks.append(record_of(entry, number))
    records = load_numpy().frombuffer(bytearray(b"".join(blocks)), log_dtype())
    return LogBatch(records, channels)


def record_of(entry: LogEntry, channel: int) -> bytes:
    """Return the 88 bytes of an entry whose channel has this number."""
    content = entry.content
    pack = _PACKING.get(type(content))
    if pack is None:
        raise BadValue(f"{content!r}: no frame, event or mark that a log could hold")
    kind, record = pack(content)
    if entry.direction not in _CODES:
        raise BadValue(f"direction {entry.direction!r}: R, T or None")
    head = entry.timestamp_ns.to_bytes(8, "little") + record[8:]
    return head + _TAIL.pack(channel, kind, _CODES[entry.direction])


def entry_of(record: bytes, channels: list[str]) -> LogEntry:
    """Return the entry in 88 bytes; raises BadValue for bytes that are no entry."""
    channel, kind, direction = _TAIL.unpack_from(record, RECORD_SIZE)
    content = _UNPACKING[kind](record[:RECORD_SIZE])
    return LogEntry(content.timestamp_ns, channels[channel], content, DIRECTIONS[direction])


def records_of_line(
    records: numpy.ndarray, channel: int, *, lin: bool = False, directed: bool = True
) -> numpy.ndarray:
    """Records of a ring (`record_dtype()`) as records of a log, all of one channel.

    Frames that the line sent (SELF_RECEPTION) get the direction T, others R; if not `directed`, it is unknown.
    """
    numpy = load_numpy()
    found = numpy.zeros(len(records), log_dtype())
    for name in ("time_ns", "id", "info", "data"):
        found[name] = records[name]
    found["channel"] = channel
    event = records["info"] >> 8 & 0xFF if lin else records["info"] & 0xFF
    found["kind"] = (event != 0) + (LogKind.LIN_FRAME if lin else LogKind.CAN_FRAME)
    if directed:
        found["direction"] = 1 + (records["info"] & (1 << 25 if lin else SELF_RECEPTION) != 0)
    return found


def renumbered(batch: LogBatch, channels: list[str]) -> numpy.ndarray:
    """The batch's records, with channels numbered as in `channels`, to which new names are appended."""
    records = batch.records
    if batch.channels is channels:
        return records
    known = {name: number for number, name in enumerate(channels)}
    for name in batch.channels:
        if name not in known:
            known[name] = len(channels)
            channels.append(name)
    numbers = [known[name] for name in batch.channels]
    if numbers != list(range(len(numbers))):
        records = records.copy()
        records["channel"] = load_numpy().array(numbers, "u2")[records["channel"]]
    return records


def in_time(records: numpy.ndarray) -> numpy.ndarray:
    """Return the records in the order of their time stamps; records with equal stamps keep their order."""
    found: numpy.ndarray = records[load_numpy().argsort(records["time_ns"], kind="stable")]
    return found


def _pack_mark(mark: LogMark) -> bytes:
    text = mark.text.encode()
    return _MARK.pack(mark.timestamp_ns, mark.kind, 0, mark.count, mark.bit_rate, mark.data_bit_rate, text)


def _unpack_mark(record: bytes) -> LogMark:
    time_ns, kind, _, count, bit_rate, data_bit_rate, text = _MARK.unpack(record)
    said = text.rstrip(b"\0").decode(errors="replace")
    return LogMark(MarkKind(kind), time_ns, count, bit_rate, data_bit_rate, said)


_PACKING: dict[type, Callable[..., tuple[int, bytes]]] = {
    Frame: lambda content: (LogKind.CAN_FRAME, record_of_frame(content)),
    BusEvent: lambda content: (LogKind.CAN_EVENT, content.to_record()),
    LinFrame: lambda content: (LogKind.LIN_FRAME, record_of_lin_frame(content)),
    LinEvent: lambda content: (LogKind.LIN_EVENT, content.to_record()),
    LogMark: lambda content: (LogKind.MARK, _pack_mark(content)),
}
_UNPACKING: dict[int, Callable[[bytes], Content]] = {
    LogKind.CAN_FRAME: frame_of_record,
    LogKind.CAN_EVENT: BusEvent.from_record,
    LogKind.LIN_FRAME: lin_frame_of_record,
    LogKind.LIN_EVENT: LinEvent.from_record,
    LogKind.MARK: _unpack_mark,
}
