"""Reads ASC: lines of any writer, and canwire's own comments; the most common lines with numpy (plain.py)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from canwire.errors import BadText
from canwire.logs.asc import plain
from canwire.logs.asc.writing import OURS
from canwire.logs.batch import LogBatch
from canwire.logs.blocks.fields import Fields
from canwire.logs.blocks.reading import read_blocks
from canwire.logs.dates import ns_of_vector_date
from canwire.logs.detail import content_of_detail, lin_frame_of_detail
from canwire.logs.entry import LogEntry, LogKind
from canwire.logs.source import Source
from canwire.values.event import BusEvent, ErrorKind, EventKind
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame

if TYPE_CHECKING:
    import numpy

_EVENT = re.compile(r"\s*(-?)(\d{1,12})\.(\d{1,9})\s+(.*)")
_FRAME = re.compile(r"(\d+)\s+([0-9A-Fa-f]+)(x?)\s+(Rx|Tx|TxRq)\s+([dr])\s*(.*)", re.IGNORECASE)
_FD = re.compile(r"CANFD\s+(\d+)\s+(Rx|Tx|TxRq)\s+([0-9A-Fa-f]+)(x?)\s+(.*)", re.IGNORECASE)
_ERROR = re.compile(r"(?:CANFD\s+)?(\d+)\s+(?:(?:Rx|Tx)\s+)?ErrorFrame\b(.*)", re.IGNORECASE)
_LIN = re.compile(r"Li?(\d*)\s+([0-9A-Fa-f]+)\s+(Rx|Tx)\s+(\d+)\s+(.*)", re.IGNORECASE)
_LIN_HEADER = re.compile(rf"Li(\d+)\s+([0-9A-Fa-f]+)\s+{OURS}\s+(.*)")
_BASE = re.compile(r"base\s+(hex|dec)\s+timestamps\s+(absolute|relative)", re.IGNORECASE)
_DATE = re.compile(r"(?:date|begin\s+triggerblock)\s+(.+)", re.IGNORECASE)
_FD_FLAGS_EDL, _FD_FLAGS_BRS, _FD_FLAGS_ESI = 1 << 12, 1 << 13, 1 << 14


def recognises(head: bytes) -> bool:
    """Recognises the format by the first lines, of which one is `date` or `base`."""
    lines = head.decode("utf-8", "replace").lstrip("\ufeff").splitlines()[:5]
    return any(_BASE.match(line) or (_DATE.match(line) and line[:4].lower() == "date") for line in lines)


def read(source: Source) -> Iterator[LogBatch]:
    """Yield frames, error frames and canwire's own comments; other events are left out."""
    return read_blocks(source, _Parser(source))


class _Parser:
    """Parses the lines of one file."""

    separator: int | None = None

    def __init__(self, source: Source) -> None:
        self._source = source
        self._base = 16
        self._relative = False
        self._latest_ns = 0
        self._zero_ns: int | None = None
        self._names: dict[int, str] = {}

    def entry(self, line: str) -> LogEntry | None:
        """Return the entry of this line; raises BadText, BadFrame, ValueError for an invalid line."""
        event = _EVENT.fullmatch(line)
        if event is None:
            if line.startswith(OURS):
                return self._comment(line)
            self._head(line)
            return None
        time_ns = self._time(event[1], event[2], event[3])
        return self._event(time_ns, event[4])

    def changing(self, fields: Fields) -> Any:
        return plain.changing(fields)

    def candidates(self, fields: Fields) -> Any:
        """Select the lines that may be plain; none if data are decimal, times relative to the previous line or out of
        range."""
        usual = self._base == 16 and not self._relative and abs(self._zero_ns or 0) < 1 << 62
        return plain.candidates(fields) if usual else fields.count < 0

    def records(self, fields: Fields, those: Any) -> tuple[numpy.ndarray, Any, Any]:
        return plain.records(fields, those, self._zero_ns or 0)

    def name(self, key: Any) -> str:
        """Return the name of the channel with this number."""
        return self._name(int(key))

    def _event(self, time_ns: int, text: str) -> LogEntry | None:
        if found := _FRAME.fullmatch(text):
            return self._frame(time_ns, found)
        if found := _FD.fullmatch(text):
            return self._fd_frame(time_ns, found)
        if found := _ERROR.fullmatch(text):
            return self._error(time_ns, found)
        if found := _LIN_HEADER.fullmatch(text):
            frame = lin_frame_of_detail(found[3], int(found[2], 16), b"", time_ns, False)
            return LogEntry(time_ns, self._name(int(found[1]), "lin"), frame)
        if found := _LIN.fullmatch(text):
            return self._lin(time_ns, found)
        return None

    def _time(self, sign: str, seconds: str, decimals: str) -> int:
        span = int(seconds) * 10**9 + int(decimals.ljust(9, "0"))
        self._latest_ns = (self._latest_ns if self._relative else 0) + (-span if sign else span)
        time_ns = self._latest_ns + (self._zero_ns or 0)
        if not 0 <= time_ns < 1 << 63:
            raise BadText(f"time {sign}{seconds}.{decimals}: before 1970, or past all clocks")
        return time_ns

    def _frame(self, time_ns: int, found: re.Match[str]) -> LogEntry:
        remote = found[5].lower() == "r"
        dlc_text, *rest = found[6].split() or ["0"]
        if not re.fullmatch("[0-9A-Fa-f]", dlc_text):  # "r" alone, or "r Length = 0 BitCount = 64"
            if not remote:
                raise BadText(f"{dlc_text!r} in the place of the data length code")
            dlc_text = "0"
        dlc = int(dlc_text, 16)
        count = 0 if remote else min(dlc, 8)
        data = bytes(int(byte, self._base) for byte in rest[:count])
        if len(data) < count:
            raise BadText(f"length {dlc}, but {len(data)} bytes")
        if dlc > 8 and not remote and re.fullmatch("[0-9A-Fa-f]{2,3}", "".join(rest[8:9])):
            raise BadText(f"more than 8 bytes behind length code {dlc}: a line of CAN FD begins with CANFD")
        frame = Frame(
            int(found[2], self._base),
            data,
            extended=bool(found[3]),
            remote=remote,
            dlc=dlc,
            timestamp_ns=time_ns,
        )
        return LogEntry(time_ns, self._name(int(found[1])), frame, _direction(found[4]))

    def _fd_frame(self, time_ns: int, found: re.Match[str]) -> LogEntry:
        if found[3].lower() == "errorframe":
            return LogEntry(time_ns, self._name(int(found[1])), _plain_error(time_ns))
        words = found[5].split()
        if not (words[0] in "01" and words[1] in "01" and len(words[2]) == 1):  # here is a symbolic name
            words = words[1:]
        brs, esi, dlc, count = words[0] == "1", words[1] == "1", int(words[2], 16), int(words[3])
        data = bytes(int(byte, self._base) for byte in words[4 : 4 + count])
        behind = words[4 + count :]
        flags = int(behind[2], 16) if len(behind) > 2 else _FD_FLAGS_EDL
        fd = bool(flags & _FD_FLAGS_EDL) or count > 8 or brs
        remote = not fd and bool(flags & 0x10)
        if len(data) < count:
            raise BadText(f"length {count}, but {len(data)} bytes")
        frame = Frame(
            int(found[3], self._base),
            b"" if remote else data,
            extended=bool(found[4]),
            remote=remote,
            fd=fd,
            bit_rate_switch=fd and brs,
            error_state_indicator=fd and esi,
            dlc=dlc,
            timestamp_ns=time_ns,
        )
        return LogEntry(time_ns, self._name(int(found[1])), frame, _direction(found[2]))

    def _error(self, time_ns: int, found: re.Match[str]) -> LogEntry:
        _, ours, told = found[2].partition(f"{OURS} CAN_EVENT ")
        event = content_of_detail(LogKind.CAN_EVENT, told, time_ns) if ours else _plain_error(time_ns)
        return LogEntry(time_ns, self._name(int(found[1])), event)

    def _lin(self, time_ns: int, found: re.Match[str]) -> LogEntry:
        count = int(found[4])
        words = found[5].split()
        data = bytes(int(byte, 16) for byte in words[:count])
        model = re.search(r"CSM = (classic|enhanced)", found[5])
        enhanced = None if model is None else model[1] == "enhanced"
        sent = found[3].lower() == "tx"
        frame = LinFrame(int(found[2], 16), data, enhanced=enhanced, timestamp_ns=time_ns, sent=sent)
        return LogEntry(time_ns, self._name(int(found[1] or 1), "lin"), frame, "T" if sent else "R")

    def _comment(self, line: str) -> LogEntry | None:
        words = line.removeprefix(OURS).split(maxsplit=3)
        if words[0] == "channel":
            self._names[int(words[1])] = line.split(maxsplit=4)[4]
            return None
        if words[0] == "start":
            if words[1] != "unknown":
                self._begin(int(words[1]))
            else:
                self._source.dated, self._source.start_ns, self._zero_ns = False, None, 0
            self._source.clock = " ".join(words[2:])
            return None
        seconds, decimals = words[0].lstrip("-").split(".")
        time_ns = self._time("-" * words[0].startswith("-"), seconds, decimals)
        content = content_of_detail(LogKind[words[2]], words[3], time_ns)
        return LogEntry(time_ns, self._name(int(words[1])), content)

    def _head(self, line: str) -> None:
        if base := _BASE.match(line):
            self._base = 16 if base[1].lower() == "hex" else 10
            self._relative = base[2].lower() == "relative"
        elif self._zero_ns is None and (date := _DATE.match(line)):
            begin_ns = ns_of_vector_date(date[1])
            if begin_ns is not None and begin_ns > 0:
                self._begin(begin_ns)

    def _begin(self, begin_ns: int) -> None:
        self._zero_ns = self._source.start_ns = begin_ns
        self._source.dated = True

    def _name(self, number: int, kind: str = "can") -> str:
        return self._names.get(number, f"{kind}{max(number - 1, 0)}")


def _direction(text: str) -> str:
    return "R" if text.lower() == "rx" else "T"


def _plain_error(time_ns: int) -> BusEvent:
    return BusEvent(EventKind.ERROR, time_ns, error=ErrorKind.OTHER)
