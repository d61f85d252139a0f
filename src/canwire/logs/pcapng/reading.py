"""Reads pcapng and pcap: runs of equal CAN packets with numpy, other blocks one by one."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from canwire.errors import BadFrame, BadLog, BadText
from canwire.logs.batch import DIRECTIONS, LogBatch
from canwire.logs.detail import content_of_detail
from canwire.logs.entry import Content, LogEntry, LogKind
from canwire.logs.pcapng.blocks import (
    COMMENT,
    EPB_FLAGS,
    IF_NAME,
    IF_TSOFFSET,
    IF_TSRESOL,
    INTERFACE,
    PACKET,
    SECTION,
    SIMPLE,
    STATISTICS,
    Block,
    Torn,
    blocks,
    options,
)
from canwire.logs.pcapng.interface import Interface
from canwire.logs.pcapng.packets import (
    CAN_LINK,
    CLASSIC_SIZE,
    COOKED_LINK,
    FD_SIZE,
    LIN_LINK,
    content_of_packet,
    frames_of_packets,
    of_cooked,
)
from canwire.logs.pcapng.writing import OURS
from canwire.logs.source import Source
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

_MAGIC = bytes.fromhex("0a0d0d0a")
_PCAP = {  # magic number of a pcap file: byte order, nanoseconds in a stamp's fraction
    bytes.fromhex("d4c3b2a1"): ("<", 1000),
    bytes.fromhex("a1b2c3d4"): (">", 1000),
    bytes.fromhex("4d3cb2a1"): ("<", 1),
    bytes.fromhex("a1b23c4d"): (">", 1),
}
_AT_ONCE = 20_000
_READ = 1 << 21
_SPAN = 64  # blocks that are looked at for being equal, more of them while they are
_LINKS = {CAN_LINK, LIN_LINK, COOKED_LINK}
_WRONG = (BadText, BadFrame, struct.error, ValueError, IndexError, KeyError)


def recognises(head: bytes) -> bool:
    """Recognises the format by its magic number."""
    return head[:4] == _MAGIC or head[:4] in _PCAP


def read(source: Source) -> Iterator[LogBatch]:
    """Yield packets of both link types; a file without any interface of CAN or LIN raises BadLog."""
    load_numpy()
    magic = source.file.read(4)
    if magic in _PCAP:
        yield from _read_pcap(source, *_PCAP[magic])
        return
    yield from _Reader(source).batches(magic)


class _Reader:
    """One pcapng file."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._interfaces: list[Interface] = []
        self._foreign: set[int] = set()
        self._order = "<"
        self._span = _SPAN

    def batches(self, begin: bytes) -> Iterator[LogBatch]:
        """Yield all batches; an incomplete block is a fault and ends the file."""
        text, at, ended = begin, 0, False
        while not ended or text:
            more = self._source.file.read(_READ)
            text, ended = text + more, not more
            used = yield from self._chunk(text, at, ended)
            text, at = text[used:], at + used
            if ended:
                break
        if not self._interfaces or {one.link for one in self._interfaces}.isdisjoint(_LINKS):
            raise BadLog(f"{self._source.path}: a capture of other links than CAN (227) and LIN (212)")

    def _chunk(self, text: bytes, base: int, last: bool) -> Any:
        """Yield batches of the complete blocks in these bytes; returns their size in bytes."""
        at, found = 0, list[LogEntry]()
        while at < len(text):
            run = self._run(text, at)
            if run is not None:
                records, size = run
                if found:
                    yield self._batch(found)
                    found = []
                self._source.infer_date(int(records["time_ns"][0]))
                yield LogBatch(records, self._source.channels)
                at += size
                continue
            block_size = self._block_size(text, at)
            if block_size is None or at + block_size > len(text):
                if last:
                    self._source.fault(f"byte {base + at}", _tear(text[at:], block_size))
                    at = len(text)
                break
            self._one(text[at : at + block_size], base + at, found)
            at += block_size
            if len(found) >= _AT_ONCE:
                yield self._batch(found)
                found = []
        if found:
            yield self._batch(found)
        return at

    def _batch(self, found: list[LogEntry]) -> LogBatch:
        self._source.infer_date(found[0].timestamp_ns)
        return self._source.batch(found)

    def _block_size(self, text: bytes, at: int) -> int | None:
        """Return the size of a block by its header; None if the block is invalid or incomplete."""
        if text[at : at + 4] == _MAGIC and len(text) >= at + 12:
            self._order = "<" if text[at + 8 : at + 12] == b"\x4d\x3c\x2b\x1a" else ">"
        if len(text) < at + 8:
            return None
        size: int = struct.unpack_from(self._order + "I", text, at + 4)[0]
        return size if size >= 12 and size % 4 == 0 and size <= self._source.limits.block_bytes else None

    def _one(self, text: bytes, at: int, found: list[LogEntry]) -> None:
        import io

        try:
            for one in blocks(io.BytesIO(text), at, self._order):
                entry = self._entry(one)
                if entry is not None:
                    found.append(entry)
        except Torn as error:
            self._source.fault(f"byte {error.at}", str(error))
        except BadLog:
            raise
        except _WRONG as error:
            self._source.fault(f"byte {at}", str(error))

    def _entry(self, one: Block) -> LogEntry | None:
        if one.kind == SECTION:
            self._interfaces = []
        elif one.kind == INTERFACE:
            if len(self._interfaces) >= self._source.limits.channels:
                raise self._source.beyond("channels", "more interfaces")
            self._interfaces.append(self._described(one))
        elif one.kind == PACKET:
            return self._packet(one)
        elif one.kind == STATISTICS:
            return self._statistics(one)
        elif one.kind == SIMPLE:
            raise BadText("a simple packet block has no time stamp")
        return None

    def _described(self, one: Block) -> Interface:
        link = struct.unpack_from(one.order + "H", one.body)[0]
        told = options(one.body, 8, one.order)
        power = told.get(IF_TSRESOL, b"\x06")[0]
        ticks = 1 << (power & 0x7F) if power & 0x80 else 10**power
        offset = int.from_bytes(
            told.get(IF_TSOFFSET, b""), "little" if one.order == "<" else "big", signed=True
        )
        name = told.get(IF_NAME, f"can{len(self._interfaces)}".encode()).decode("utf-8", "replace")
        channel = self._source.channel(name) if link in _LINKS else 0
        return Interface(channel, link, ticks, offset * 10**9)

    def _packet(self, one: Block) -> LogEntry | None:
        number, high, low, size = struct.unpack_from(one.order + "IIII", one.body)
        interface = self._interfaces[number]
        if interface.link not in _LINKS:
            if number not in self._foreign:
                self._foreign.add(number)
                self._source.fault(
                    f"byte {one.at}", f"interface {number} has link type {interface.link}: left out"
                )
            return None
        told = options(one.body, 20 + size + -size % 4, one.order)
        flags = int.from_bytes(told.get(EPB_FLAGS, b""), "little" if one.order == "<" else "big")
        direction = DIRECTIONS[flags & 3] if flags & 3 < 3 else None
        time_ns = interface.time_ns(high << 32 | low)
        content: Content
        comment = told.get(COMMENT, b"").decode("utf-8", "replace")
        if comment.startswith(f"{OURS}CAN_EVENT "):
            content = content_of_detail(LogKind.CAN_EVENT, comment.split(" ", 2)[2], time_ns)
        else:
            packet, link = one.body[20 : 20 + size], interface.link
            if link == COOKED_LINK:
                packet, sent = of_cooked(packet, one.order)
                link, direction = CAN_LINK, "T" if sent else "R"
            content = content_of_packet(link, packet, time_ns, direction == "T")
        return LogEntry(time_ns, self._source.channels[interface.channel], content, direction)

    def _statistics(self, one: Block) -> LogEntry | None:
        number, high, low = struct.unpack_from(one.order + "III", one.body)
        comment = options(one.body, 12, one.order).get(COMMENT, b"").decode("utf-8", "replace")
        if not comment.startswith(OURS):
            return None
        interface = self._interfaces[number]
        time_ns = interface.time_ns(high << 32 | low)
        kind, text = comment.removeprefix(OURS).split(" ", 1)
        content = content_of_detail(LogKind[kind], text, time_ns)
        return LogEntry(time_ns, self._source.channels[interface.channel], content)

    def _run(self, text: bytes, at: int) -> tuple[numpy.ndarray, int] | None:
        """Return the records of equal CAN packets, in canwire's own layout, that follow each other from here on; None
        for few."""
        numpy = load_numpy()
        if self._order != "<" or len(text) < at + 8 or text[at] != PACKET:
            return None
        size = int.from_bytes(text[at + 4 : at + 8], "little")
        if size not in (CLASSIC_SIZE + 44, FD_SIZE + 44):
            return None
        count = min((len(text) - at) // size, self._span)
        words = numpy.frombuffer(text, "<u4", count * size // 4, at).reshape(count, size // 4)
        equal = (words[:, 0] == PACKET) & (words[:, 1] == size) & (words[:, -1] == size)
        equal &= (words[:, 5] == size - 44) & (words[:, -4] == EPB_FLAGS | 4 << 16) & (words[:, -3] < 3)
        equal &= words[:, 2] < len(self._interfaces)
        self._span = min(4 * self._span, _READ) if equal.all() else _SPAN
        count = count if equal.all() else int(equal.argmin())
        if count < 8:
            return None
        return self._of_run(words[:count], size)

    def _of_run(self, words: Any, size: int) -> tuple[numpy.ndarray, int] | None:
        numpy = load_numpy()
        used = [self._interfaces[number] for number in numpy.unique(words[:, 2]).tolist()]
        if any(one.link != CAN_LINK or one.ticks_per_s != 10**9 or one.offset_ns for one in used):
            return None
        rows = numpy.ascontiguousarray(words).view("u1").reshape(len(words), size)
        records, fit = frames_of_packets(rows[:, 28 : size - 16])
        if not fit.all():
            words, records = words[: int(fit.argmin())], records[: int(fit.argmin())]
        if len(words) < 8:
            return None
        records["time_ns"] = words[:, 3].astype("u8") << numpy.uint64(32) | words[:, 4]
        channels = numpy.array([one.channel for one in self._interfaces], "u2")
        records["channel"] = channels[words[:, 2]]
        records["direction"] = words[:, -3]
        return records, len(words) * size


def _tear(rest: bytes, size: int | None) -> str:
    if size is None and len(rest) >= 8:
        return f"no block: {rest[:8].hex(' ')}"
    return "the file ends in the middle of a block"


def _read_pcap(source: Source, order: str, scale: int) -> Iterator[LogBatch]:
    head = source.file.read(20)
    link = struct.unpack_from(order + "I", head, 16)[0] & 0xFFFF if len(head) == 20 else 0
    if link not in _LINKS:
        raise BadLog(f"{source.path}: a capture of link type {link}, not of CAN (227) or LIN (212)")
    at, found = 24, list[LogEntry]()
    while block := source.file.read(16):
        size = struct.unpack_from(order + "I", block, 8)[0] if len(block) == 16 else 0
        packet = source.file.read(min(size, 1 << 16))
        if len(block) < 16 or len(packet) < size:
            source.fault(f"byte {at}", "the file ends in the middle of a packet")
            break
        seconds, rest = struct.unpack_from(order + "II", block)
        time_ns = seconds * 10**9 + rest * scale
        try:
            if link == COOKED_LINK:
                packet, sent = of_cooked(packet, order)
            direction = None if link != COOKED_LINK else "T" if sent else "R"
            content = content_of_packet(CAN_LINK if direction else link, packet, time_ns, False)
            found.append(LogEntry(time_ns, "can0", content, direction))
        except _WRONG as error:
            source.fault(f"byte {at}", str(error))
        at += 16 + size
        if len(found) >= _AT_ONCE:
            source.infer_date(found[0].timestamp_ns)
            yield source.batch(found)
            found = []
    if found:
        source.infer_date(found[0].timestamp_ns)
        yield source.batch(found)
