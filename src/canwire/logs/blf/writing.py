"""Writes BLF: CAN frames with numpy, other entries one by one."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING, Any, ClassVar

from canwire.logs.batch import LOG_RECORD_SIZE, entry_of
from canwire.logs.blf import layout as b
from canwire.logs.detail import detail_of
from canwire.logs.entry import LogEntry, LogKind
from canwire.logs.form import FormWriter, write_all
from canwire.logs.rows import in_order
from canwire.logs.tables.columns import lengths_of
from canwire.values.event import BusEvent, EventKind
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

_MS = 1_000_000
_CONTAINER = 1 << 17  # bytes before compression
_SIZES = {0: b.TIMED.size + b.CAN.size, 1: b.TIMED.size + b.FD.size}
_OBJECTS = (b.CAN_MESSAGE, b.CAN_FD)
_KINDS = {"BusEvent": "CAN_EVENT", "LinEvent": "LIN_EVENT", "LogMark": "MARK", "LinFrame": "LIN_FRAME"}
_PIECE = 2048


class Writer(FormWriter):
    """Channels are written as numbers; names, marks, LIN events and details of errors are texts: `canwire ...`."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)

    def begin(self) -> None:
        self._zero_ns: int | None = None
        self._latest_ns = 0
        self._named = 0
        self._objects = 0
        self._unpacked = b.HEAD_SIZE
        self._held: list[tuple[bytes, int]] = []
        self._size = 0
        self.out(self._head())

    def put(self, records: numpy.ndarray) -> None:
        numpy = load_numpy()
        if self._zero_ns is None:
            self._start(int(records["time_ns"].min()))
        records = self._begun(records)
        self._latest_ns = max(self._latest_ns, int(records["time_ns"].max()))
        unknown = (records["direction"] == 0) & (records["kind"] == LogKind.CAN_FRAME)
        if count := int(unknown.sum()):
            self.leave_out("directions that are not known (Rx is written)", count)
        for number in range(self._named, len(self.channels)):
            self._text(self._zero_ns or 0, f"channel {number + 1} {self.channels[number]}", 0)
        self._named = len(self.channels)
        plain = records["kind"] == LogKind.CAN_FRAME
        for part in numpy.split(records, numpy.flatnonzero(numpy.diff(plain)) + 1):
            if part["kind"][0] == LogKind.CAN_FRAME:
                for at in range(0, len(part), _PIECE):
                    piece = part[at : at + _PIECE]
                    fd = (piece["info"] & EXTENDED_DATA_LENGTH != 0).astype("u1")
                    self._hold(in_order(piece, fd, _SIZES, self._frames), len(piece), len(piece))
                continue
            stored = part.tobytes()
            for at in range(0, len(stored), LOG_RECORD_SIZE):
                self._other(entry_of(stored[at : at + LOG_RECORD_SIZE], self.channels))

    def sync(self) -> None:
        """Write a container of the waiting objects, and the updated head if the file can be rewound."""
        self._pack()
        super().sync()
        if self.file is not None and self.file.seekable():
            end = self.file.tell()
            self.file.seek(0)
            write_all(self.file, self._head(end))
            self.file.seek(end)

    def _begun(self, records: numpy.ndarray) -> numpy.ndarray:
        """Return the records without times before the log's beginning: objects have unsigned times from there on."""
        early = records["time_ns"] < (self._zero_ns or 0)
        if early.any():
            self.leave_out("times before the log's beginning (that is written)", int(early.sum()))
            records = records.copy()
            records["time_ns"][early] = self._zero_ns
        return records

    def _start(self, first_ns: int) -> None:
        begin_ns = first_ns if self.start_ns is None else min(first_ns, self.start_ns)
        self._zero_ns = begin_ns // _MS * _MS if self.dated else 0  # the head's date has milliseconds
        if self._waiting and self._waiting[0][0].startswith(b.MAGIC):
            self._waiting[0] = self._head(), 0  # a pipe or a packed file cannot be rewound for its date
        if self.clock:
            self._text(self._zero_ns, f"clock {self.clock}", 0)

    def _hold(self, block: bytes, objects: int, entries: int) -> None:
        self._held.append((block, entries))
        self._size += len(block)
        self._objects += objects
        if self._size >= _CONTAINER:
            self._pack()

    def _pack(self) -> None:
        if not self._held:
            return
        content = b"".join(block for block, _ in self._held)
        entries = sum(count for _, count in self._held)
        self._held, self._size = [], 0
        packed = zlib.compress(content, 1)
        size = b.CONTAINER_HEAD.size + len(packed)
        head = b.CONTAINER_HEAD.pack(b.OBJECT_MAGIC, 16, 1, size, b.CONTAINER, b.ZLIB, len(content))
        self._unpacked += b.CONTAINER_HEAD.size + len(content)
        self.out(head + packed + b"\0" * (size % 4), entries)  # other readers skip size % 4 bytes

    def _head(self, size: int = b.HEAD_SIZE) -> bytes:
        start = self._zero_ns if self.dated else None
        stop = self._latest_ns if self.dated and self._zero_ns is not None else None
        return b.HEAD.pack(b.MAGIC, b.HEAD_SIZE, 5, 0, 0, 0, 2, 6, 8, 1, size, self._unpacked, self._objects, 0,
                           *b.system_time(start), *b.system_time(stop))  # fmt: skip

    def _frames(self, records: numpy.ndarray, kind: int) -> Any:
        """Return objects of CAN frames of one kind, as rows of bytes."""
        numpy = load_numpy()
        info = records["info"]
        size = _SIZES[kind]
        rows = numpy.zeros((len(records), size), "u1")
        words = rows.view("<u4")
        words[:, 0] = int.from_bytes(b.OBJECT_MAGIC, "little")
        words[:, 1] = b.TIMED.size | 1 << 16
        words[:, 2] = size
        words[:, 3] = _OBJECTS[kind]
        words[:, 4] = b.NANOSECONDS
        relative = records["time_ns"] - numpy.uint64(self._zero_ns or 0)
        words[:, 6] = relative & numpy.uint64(0xFFFF_FFFF)
        words[:, 7] = relative >> numpy.uint64(32)
        flags = numpy.where(records["direction"] == 2, b.SENT, 0) | numpy.where(info & REMOTE, b.REMOTE, 0)
        dlc = info >> DLC_SHIFT & 15
        words[:, 8] = records["channel"].astype("u4") + 1 | flags.astype("u4") << 16 | dlc << 24
        words[:, 9] = records["id"] | numpy.where(info & EXTENDED, b.EXTENDED, 0).astype("u4")
        if kind == 0:
            rows[:, 40:48] = records["data"][:, :8]
            return rows
        rows[:, 45] = (
            b.EDL + (info & FAST_DATA_RATE != 0) * b.BRS + (info & ERROR_STATE_INDICATOR != 0) * b.ESI
        )
        rows[:, 46] = lengths_of(records)
        rows[:, 52:116] = records["data"]
        return rows

    def _other(self, entry: LogEntry) -> None:
        content, channel = entry.content, self.channels.index(entry.channel) + 1
        time_ns = entry.timestamp_ns
        direction = entry.direction or "-"
        if isinstance(content, BusEvent) and content.kind is EventKind.ERROR:
            self._text(time_ns, f"NEXT {channel} {direction} CAN_EVENT {detail_of(content)}", 0)
            body = b.ERROR_EXT.pack(channel, 0, 0, 0, 0, 0, 0, 0, 0, bytes(8))
            self._object(b.CAN_ERROR_EXT, time_ns, body, 1)
        elif isinstance(content, LinFrame) and not content.header_only:
            if detail := detail_of(content):
                self._text(time_ns, f"NEXT {channel} {direction} LIN_FRAME {detail}", 0)
            sent = direction == "T"
            body = b.LIN.pack(
                channel, content.id, len(content.data), content.data, 0, 0, 0, 0, content.checksum, sent
            )
            self._object(b.LIN_MESSAGE, time_ns, body, 1)
        else:
            kind = _KINDS[type(content).__name__]
            id = f"{content.id} " if isinstance(content, LinFrame) else ""
            self._text(time_ns, f"{kind} {channel} {direction} {id}{detail_of(content)}", 1)

    def _text(self, time_ns: int, text: str, entries: int) -> None:
        told = (b.OURS + text).encode()
        self._object(b.APP_TEXT, time_ns, b.TEXT.pack(0, 0, len(told), 0) + told, entries)

    def _object(self, kind: int, time_ns: int, body: bytes, entries: int) -> None:
        size = b.TIMED.size + len(body)
        relative = time_ns - (self._zero_ns or 0)
        head = b.TIMED.pack(b.OBJECT_MAGIC, b.TIMED.size, 1, size, kind, b.NANOSECONDS, 0, 0, relative)
        self._hold(head + body + b"\0" * (size % 4), 1, entries)


assert struct.calcsize("<4sI8BQQII8H8H72x") == b.HEAD_SIZE
