"""Writes pcapng: CAN frames with numpy, other entries one by one."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, ClassVar

from canwire.logs.batch import DIRECTIONS, LOG_RECORD_SIZE, entry_of
from canwire.logs.detail import detail_of
from canwire.logs.entry import LogEntry, LogKind, LogMark, MarkKind
from canwire.logs.form import FormWriter
from canwire.logs.pcapng.blocks import (
    BYTE_ORDER,
    COMMENT,
    EPB_FLAGS,
    IF_NAME,
    IF_TSRESOL,
    INTERFACE,
    ISB_DROPPED,
    PACKET,
    SECTION,
    STATISTICS,
    block,
)
from canwire.logs.pcapng.packets import (
    CAN_LINK,
    CLASSIC_SIZE,
    FD_SIZE,
    LIN_LINK,
    content_of_packet,
    packet_of_event,
    packet_of_lin,
    packets_of_frames,
)
from canwire.values.event import BusEvent
from canwire.values.lin.frame import LinFrame
from canwire.values.record import EXTENDED_DATA_LENGTH, load_numpy

if TYPE_CHECKING:
    import numpy

OURS = "canwire "  # before a comment's kind and JSON
_AROUND = 44  # bytes of a packet's block besides the packet: 28 before it, flags, end of options, size
_PIECE = 16_384


class Writer(FormWriter):
    """A section with an interface for every channel; time stamps in nanoseconds."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)

    def begin(self) -> None:
        self._interfaces: dict[tuple[int, int], int] = {}
        body = struct.pack("<IHHq", BYTE_ORDER, 1, 0, -1)
        self.out(block(SECTION, body, {4: b"canwire"}))

    def put(self, records: numpy.ndarray) -> None:
        numpy = load_numpy()
        plain = records["kind"] == LogKind.CAN_FRAME
        edges = numpy.flatnonzero(numpy.diff(plain)) + 1
        for part in numpy.split(records, edges):
            if part["kind"][0] == LogKind.CAN_FRAME:
                for at in range(0, len(part), _PIECE):
                    self._put_frames(part[at : at + _PIECE])
                continue
            stored = part.tobytes()
            for at in range(0, len(stored), LOG_RECORD_SIZE):
                record = stored[at : at + LOG_RECORD_SIZE]
                self._put_other(entry_of(record, self.channels), int.from_bytes(record[80:82], "little"))

    def _put_frames(self, records: numpy.ndarray) -> None:
        numpy = load_numpy()
        used = numpy.unique(records["channel"]).tolist()
        interfaces = numpy.zeros(max(used) + 1, "<u4")
        interfaces[used] = [self._interface(number, CAN_LINK) for number in used]
        fd = records["info"] & EXTENDED_DATA_LENGTH != 0
        sizes = numpy.where(fd, FD_SIZE, CLASSIC_SIZE) + _AROUND
        begins = numpy.concatenate(([0], numpy.cumsum(sizes)))
        blocks = numpy.zeros(int(begins[-1]), "u1")
        for size, those in ((CLASSIC_SIZE, ~fd), (FD_SIZE, fd)):
            if those.any():
                rows = _blocks(records[those], interfaces, size)
                if len(rows) == len(records):
                    blocks = rows.reshape(-1)
                else:
                    blocks[begins[:-1][those][:, None] + numpy.arange(size + _AROUND)] = rows
        self.out(blocks.tobytes(), len(records))

    def _put_other(self, entry: LogEntry, channel: int) -> None:
        content = entry.content
        if isinstance(content, BusEvent):
            packet = packet_of_event(content)
            same = content_of_packet(CAN_LINK, packet, content.timestamp_ns, False) == content
            self._put_packet(
                entry, self._interface(channel, CAN_LINK), packet, "" if same else detail_of(content)
            )
        elif isinstance(content, LinFrame):
            self._put_packet(entry, self._interface(channel, LIN_LINK), packet_of_lin(content), "")
        else:
            link = CAN_LINK if isinstance(content, LogMark) else LIN_LINK
            told = {COMMENT: f"{OURS}{_KINDS[type(content).__name__]} {detail_of(content)}".encode()}
            if isinstance(content, LogMark) and content.kind is MarkKind.LOST:
                told[ISB_DROPPED] = content.count.to_bytes(8, "little")
            body = struct.pack("<I", self._interface(channel, link)) + _stamp(entry.timestamp_ns)
            self.out(block(STATISTICS, body, told), 1)

    def _put_packet(self, entry: LogEntry, interface: int, packet: bytes, detail: str) -> None:
        told = {EPB_FLAGS: DIRECTIONS.index(entry.direction).to_bytes(4, "little")}
        if detail:
            told[COMMENT] = f"{OURS}CAN_EVENT {detail}".encode()
        size = struct.pack("<II", len(packet), len(packet))
        body = struct.pack("<I", interface) + _stamp(entry.timestamp_ns) + size + packet
        self.out(block(PACKET, body, told), 1)

    def _interface(self, channel: int, link: int) -> int:
        """Return the number of a channel's interface; a new interface is described first."""
        known = self._interfaces.get((channel, link))
        if known is None:
            known = self._interfaces[channel, link] = len(self._interfaces)
            told = {IF_NAME: self.channels[channel].encode(), IF_TSRESOL: b"\x09"}
            self.out(block(INTERFACE, struct.pack("<HHI", link, 0, 0), told))
        return known


_KINDS = {"LinEvent": "LIN_EVENT", "LogMark": "MARK"}


def _stamp(time_ns: int) -> bytes:
    return struct.pack("<II", time_ns >> 32, time_ns & 0xFFFF_FFFF)


def _blocks(records: numpy.ndarray, interfaces: Any, size: int) -> Any:
    """Return enhanced packet blocks of CAN frames, in rows of bytes."""
    numpy = load_numpy()
    rows = numpy.zeros((len(records), size + _AROUND), "u1")
    words = rows.view("<u4")
    words[:, 0] = PACKET
    words[:, 1] = words[:, -1] = size + _AROUND
    words[:, 2] = interfaces[records["channel"]]
    words[:, 3] = records["time_ns"] >> numpy.uint64(32)
    words[:, 4] = records["time_ns"] & numpy.uint64(0xFFFF_FFFF)
    words[:, 5] = words[:, 6] = size
    rows[:, 28 : 28 + size] = packets_of_frames(records, size)
    words[:, -4] = EPB_FLAGS | 4 << 16
    words[:, -3] = records["direction"]
    return rows
