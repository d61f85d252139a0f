"""BUSMASTER's logs, read only: `22:20:14:992 Rx 0 0000021A s 8 FE 36 12 FE 69 05 07 AD`.

The head contains the date and the zero of times: the start of the day, of the session, or the previous line. Lines of
LIN and J1939 have other columns; a J1939 message of more than 8 bytes is not a frame.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import datetime

from canwire.errors import BadText
from canwire.logs.batch import LogBatch
from canwire.logs.dates import ns_of
from canwire.logs.entry import LogEntry
from canwire.logs.lines import read_lines
from canwire.logs.source import Source
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame

_START = re.compile(r"\*\*\*START DATE AND TIME (\d+):(\d+):(\d+) (\d+):(\d+):(\d+):(\d+)\*\*\*")
_MODE = re.compile(r"\*\*\*(SYSTEM|ABSOLUTE|RELATIVE) MODE\*\*\*")
_LINE = re.compile(r"(\d+):(\d+):(\d+):(\d+)\s+(Rx|Tx)\s+(\d+)\s+(\w+)\s+(s|x|sr|xr)\s+(\d+)\s*(.*)")
_J1939 = re.compile(
    r"(\d+):(\d+):(\d+):(\d+)\s+(\d+)\s+(\w+)\s+0x\w+\s+\w+\s+\w+\s+\w+\s+\w+\s+(Rx|Tx)\s+(\d+)\s*(.*)"
)
_LIN = re.compile(
    r"(\d+):(\d+):(\d+):(\d+)\s+(Rx|Tx)\s+(\d+)\s+(0x\w+)\s+(\d+)\s+((?:\w{2,3}\s+)*)0x\w+ \((\w+)\)"
)
_DAY_NS = 86_400 * 10**9


def recognises(head: bytes) -> bool:
    """Recognised by the first line, or in an edited log by the line with the names of the columns."""
    return head.startswith(b"***BUSMASTER") or b"***<Time><" in head


def read(source: Source) -> Iterator[LogBatch]:
    """Yields frames; each other line below the head is a fault."""
    return read_lines(source, _Parser(source).entry)


class _Parser:
    """Parses the lines of one file."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._base = 16
        self._mode = "SYSTEM"
        self._begin_ns = 0
        self._midnight_ns = 0
        self._latest_ns = 0

    def entry(self, line: str) -> LogEntry | None:
        """Return the entry of this line; raises BadText, BadFrame, ValueError for an invalid line."""
        if line.startswith("***"):
            self._head(line)
            return None
        if not line.strip():
            return None
        if found := _LIN.fullmatch(line.strip()):
            return self._lin(found)
        if found := _J1939.fullmatch(line.strip()):
            if int(found[8]) > 8:
                raise BadText(f"a message of {found[8]} bytes, which were several frames")
            return self._can(found, found[5], found[6], "x", found[8], found[9], found[7])
        if found := _LINE.fullmatch(line.strip()):
            return self._can(found, found[6], found[7], found[8], found[9], found[10], found[5])
        raise BadText(f"{line[:100]!r} is no line of BUSMASTER")

    def _can(
        self, found: re.Match[str], channel: str, id: str, kind: str, count: str, bytes_: str, direction: str
    ) -> LogEntry:
        data = bytes(int(byte, self._base) for byte in bytes_.split())
        length, remote = int(count), "r" in kind
        if not remote and len(data) != length:
            raise BadText(f"length {length}, but {len(data)} bytes")
        time_ns = self._time(found)
        frame = Frame(
            int(id.removeprefix("0x"), self._base),
            b"" if remote else data,
            extended="x" in kind,
            remote=remote,
            fd=length > 8,
            dlc=length if remote else None,
            timestamp_ns=time_ns,
        )
        return LogEntry(time_ns, f"can{channel}", frame, "R" if direction == "Rx" else "T")

    def _lin(self, found: re.Match[str]) -> LogEntry:
        data = bytes(int(byte, self._base) for byte in found[9].split())
        if len(data) != int(found[8]):
            raise BadText(f"length {found[8]}, but {len(data)} bytes")
        time_ns, sent = self._time(found), found[5] == "Tx"
        enhanced = found[10] == "Enhanced"
        frame = LinFrame(int(found[7], 16), data, enhanced=enhanced, timestamp_ns=time_ns, sent=sent)
        return LogEntry(time_ns, f"lin{found[6]}", frame, "T" if sent else "R")

    def _time(self, found: re.Match[str]) -> int:
        hour, minute, second = (int(found[number]) for number in (1, 2, 3))
        rest = int(found[4].ljust(9, "0")) if len(found[4]) > 3 else int(found[4]) * 1_000_000
        passed_ns = (hour * 3600 + minute * 60 + second) * 10**9 + rest
        if self._mode != "SYSTEM":
            self._latest_ns = passed_ns + (self._latest_ns if self._mode == "RELATIVE" else self._begin_ns)
            return self._latest_ns
        time_ns = self._midnight_ns + passed_ns
        if time_ns < self._latest_ns - _DAY_NS // 2:  # past midnight
            self._midnight_ns += _DAY_NS
            time_ns += _DAY_NS
        self._latest_ns = time_ns
        return time_ns

    def _head(self, line: str) -> None:
        if found := _START.match(line):
            day, month, year, hour, minute, second, milli = (int(word) for word in found.groups())
            begin = datetime(year, month, day, hour, minute, second, milli * 1000)
            self._source.start_ns = self._begin_ns = self._latest_ns = ns_of(begin)
            self._source.dated = True
            self._midnight_ns = ns_of(begin.replace(hour=0, minute=0, second=0, microsecond=0))
        elif line.startswith("***DEC***"):
            self._base = 10
        elif found := _MODE.match(line):
            self._mode = found[1]
