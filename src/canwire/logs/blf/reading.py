"""Reads BLF: runs of equal CAN objects with numpy, other objects one by one."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from canwire.errors import BadFrame, BadText, BadValue
from canwire.logs.batch import LogBatch, log_dtype
from canwire.logs.blf import layout as b
from canwire.logs.blf.objects import content_of_object, text_of_object
from canwire.logs.detail import content_of_detail, lin_frame_of_detail
from canwire.logs.entry import LogEntry, LogKind
from canwire.logs.source import Source
from canwire.values.lin.frame import LinFrame
from canwire.values.record import DLC_SHIFT, EXTENDED, REMOTE, load_numpy

if TYPE_CHECKING:
    import numpy

_AT_ONCE = 20_000
_CONTAINER_HEAD = 16
_FEW = 8  # equal objects that are not worth numpy
_SPAN = 64  # objects that are looked at for being equal, more of them while they are
_LARGEST_SPAN = 1 << 20
_CAN_SIZE = b.TIMED.size + b.CAN.size
_WRONG = (BadText, BadFrame, BadValue, struct.error, ValueError, IndexError, KeyError)


def recognises(head: bytes) -> bool:
    """Recognises the format by its magic number."""
    return head.startswith(b.MAGIC)


def read(source: Source) -> Iterator[LogBatch]:
    """Yield the entries of all containers; an incomplete container is a fault and ends the file."""
    load_numpy()
    reader = _Reader(source)
    at = reader.head(source.file.read(b.HEAD_SIZE))
    source.file.read(at - b.HEAD_SIZE)
    while base := source.file.read(b.BASE.size):
        if len(base) < b.BASE.size or not base.startswith(b.OBJECT_MAGIC):
            source.fault(f"byte {at}", "no object begins here: the file is cut or damaged")
            break
        size, kind = b.BASE.unpack(base)[3:]
        body = (
            source.file.read(size - b.BASE.size) if b.BASE.size <= size <= source.limits.block_bytes else b""
        )
        source.file.read(size % 4)
        if len(body) < size - b.BASE.size:
            source.fault(f"byte {at}", "the file ends in the middle of an object")
            if kind == b.CONTAINER and len(body) > _CONTAINER_HEAD:
                yield from reader.objects(_unpacked(source, at, body), at)
            return  # the object that is cut is said already
        content = _unpacked(source, at, body) if kind == b.CONTAINER else base + body
        yield from reader.objects(content, at)
        at += size + size % 4
    reader.finish(at)


def _unpacked(source: Source, at: int, body: bytes) -> bytes:
    """Unpack a container; of a damaged one, return the part that can be unpacked."""
    method = int.from_bytes(body[:2], "little")
    packed = body[_CONTAINER_HEAD:]
    if method == b.NO_COMPRESSION:
        return packed
    if method != b.ZLIB:
        source.fault(f"byte {at}", f"a container packed by method {method}")
        return b""
    opener = zlib.decompressobj()
    found, most = bytearray(), source.limits.block_bytes
    try:
        for begin in range(0, len(packed), 4096):
            piece = packed[begin : begin + 4096]
            while piece:
                found += opener.decompress(piece, most + 1 - len(found))
                if len(found) > most:
                    raise source.beyond("block_bytes", f"byte {at}: a container that unpacks to more bytes")
                piece = opener.unconsumed_tail
    except zlib.error as error:
        source.fault(f"byte {at}", f"a damaged container: {error}")
    return bytes(found)


class _Reader:
    """Reads the objects of one file."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._zero_ns = 0
        self._names: dict[int, str] = {}
        self._next: tuple[str, str] | None = None  # kind and detail of the object that follows
        self._tail = bytearray()
        self._missing = 0  # bytes that have to come before the tail is looked at
        self._span = _SPAN

    def head(self, head: bytes) -> int:
        """Read the file's header; returns the place of the first object."""
        if len(head) < b.HEAD_SIZE:
            self._source.fault("byte 0", f"a head of {len(head)} bytes, not {b.HEAD_SIZE}")
            return b.HEAD_SIZE
        values = b.HEAD.unpack(head)
        begin_ns = b.ns_of_system_time(values[14:22])
        if begin_ns is not None:
            self._zero_ns = self._source.start_ns = begin_ns
            self._source.dated = True
        return max(int(values[1]), b.HEAD_SIZE)

    def finish(self, at: int) -> None:
        """Report a fault if the last object is incomplete."""
        if self._tail.strip(b"\0"):
            self._source.fault(f"byte {at}", f"the last object is cut: {len(self._tail)} bytes of it")

    def objects(self, content: bytes, base: int) -> Iterator[LogBatch]:
        """Yield batches of the objects in a container, including an object that began in the previous container."""
        self._tail += content
        if len(self._tail) < self._missing:
            return
        text, at, found = bytes(self._tail), 0, list[LogEntry]()
        self._missing, most = 0, self._source.limits.block_bytes
        while True:
            begin = text.find(b.OBJECT_MAGIC, at)
            if begin < 0:
                break
            if begin - at > 8:
                self._source.fault(f"byte {base}", f"{begin - at} bytes of a container mean nothing")
            run = self._run(text, begin)
            if run is not None:
                if found:
                    yield self._source.batch(found)
                    found = []
                yield LogBatch(run, self._source.channels)
                at = begin + len(run) * _CAN_SIZE
                continue
            if begin + b.BASE.size > len(text):
                at = begin
                break
            size = b.BASE.unpack_from(text, begin)[3]
            if begin + size > len(text) and size <= most:
                at, self._missing = begin, size
                break
            at = begin + max(size if size <= most else 0, b.BASE.size)
            self._one(text[begin:at], base, found)
        kept = text.find(b.OBJECT_MAGIC, at) >= 0 or len(text) - at < 4
        self._tail = bytearray(text[at:] if kept else b"")
        if found:
            yield self._source.batch(found)

    def _one(self, block: bytes, base: int, found: list[LogEntry]) -> None:
        try:
            entry = self._entry(block)
            if entry is not None:
                found.append(entry)
        except _WRONG as error:
            self._source.fault(f"byte {base}", str(error))

    def _entry(self, block: bytes) -> LogEntry | None:
        size, version, _, kind = b.BASE.unpack_from(block)[1:5]
        if version == 1:
            flags, _, _, ticks = struct.unpack_from("<IHHQ", block, b.BASE.size)
        else:
            flags, _, _, ticks = b.TIMED_2.unpack_from(block, b.BASE.size)
        time_ns = self._zero_ns + ticks * (10_000 if flags == b.TEN_MICROSECONDS else 1)
        body = block[size:]
        if kind == b.APP_TEXT:
            return self._said(text_of_object(body), time_ns)
        told, self._next = self._next, None
        made = content_of_object(kind, body, time_ns)
        if made is None:
            return None
        number, content, direction = made
        if told is not None and told[0] == "CAN_EVENT":
            content = content_of_detail(LogKind.CAN_EVENT, told[1], time_ns)
        elif told is not None and isinstance(content, LinFrame):
            content = lin_frame_of_detail(told[1], content.id, content.data, time_ns, content.sent)
        return LogEntry(time_ns, self._name(number, isinstance(content, LinFrame)), content, direction)

    def _said(self, text: str, time_ns: int) -> LogEntry | None:
        """Interpret a text that canwire wrote: a channel's name, a detail of the next object, or an entry."""
        if not text.startswith(b.OURS):
            return None
        word, rest = text.removeprefix(b.OURS).split(" ", 1)
        if word == "channel":
            number, name = rest.split(" ", 1)
            self._names[int(number)] = name
            return None
        if word == "clock":
            self._source.clock = rest
            return None
        number, direction, told = rest.split(" ", 2)
        if word == "NEXT":
            kind, detail = told.split(" ", 1)
            self._next = kind, detail
            return None
        sent = direction == "T"
        content: Any
        if word == "LIN_FRAME":
            id, detail = told.split(" ", 1)
            content = lin_frame_of_detail(detail, int(id), b"", time_ns, sent)
        else:
            content = content_of_detail(LogKind[word], told, time_ns)
        return LogEntry(
            time_ns, self._name(int(number), False), content, None if direction == "-" else direction
        )

    def _name(self, number: int, lin: bool) -> str:
        return self._names.get(number, f"{'lin' if lin else 'can'}{max(number - 1, 0)}")

    def _run(self, text: bytes, at: int) -> numpy.ndarray | None:
        """Return the records of equal CAN_MESSAGE objects that follow each other from here on; None if there are only
        few."""
        if int.from_bytes(text[at + 8 : at + 12], "little") != _CAN_SIZE or self._next is not None:
            return None
        numpy = load_numpy()
        count = min((len(text) - at) // _CAN_SIZE, self._span)
        rows = numpy.frombuffer(text, "u1", count * _CAN_SIZE, at).reshape(count, _CAN_SIZE)
        words = numpy.ascontiguousarray(rows).view("<u4")
        magic = int.from_bytes(b.OBJECT_MAGIC, "little")
        equal = (words[:, 0] == magic) & (words[:, 1] == b.TIMED.size | 1 << 16) & (words[:, 2] == _CAN_SIZE)
        equal &= (words[:, 3] == b.CAN_MESSAGE) & (words[:, 4] == b.NANOSECONDS)
        flags = rows[:, 34]
        dlc, remote, extended = rows[:, 35], flags & b.REMOTE != 0, words[:, 9] & b.EXTENDED != 0
        id = words[:, 9] & 0x1FFF_FFFF
        equal &= (dlc < 16) & (extended | (id <= 0x7FF))
        self._span = min(4 * self._span, _LARGEST_SPAN) if equal.all() else _SPAN
        count = count if equal.all() else int(equal.argmin())
        if count < _FEW:
            return None
        found = numpy.zeros(count, log_dtype())
        ticks = words[:count, 6].astype("u8") | words[:count, 7].astype("u8") << numpy.uint64(32)
        found["time_ns"] = ticks + numpy.uint64(self._zero_ns)
        found["id"] = id[:count]
        info = dlc.astype("u4") << DLC_SHIFT | numpy.where(extended, EXTENDED, 0).astype("u4")
        found["info"] = (info | numpy.where(remote, REMOTE, 0).astype("u4"))[:count]
        keep = numpy.arange(8) < numpy.where(remote, 0, dlc)[:count, None]
        found["data"][:, :8] = numpy.where(keep, rows[:count, 40:48], 0)
        found["direction"] = 1 + (flags[:count] & b.SENT)
        numbers = words[:count, 8] & 0xFFFF
        for number in numpy.unique(numbers).tolist():
            found["channel"][numbers == number] = self._source.channel(self._name(number, False))
        return found
