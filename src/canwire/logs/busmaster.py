"""BUSMASTER's logs, read only: `22:20:14:992 Rx 0 0000021A s 8 FE 36 12 FE 69 05 07 AD`.

The time is that of the day; the date stands in the head.
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

_START = re.compile(r"\*\*\*START DATE AND TIME (\d+):(\d+):(\d+) (\d+):(\d+):(\d+):(\d+)\*\*\*")
_LINE = re.compile(r"(\d+):(\d+):(\d+):(\d+)\s+(Rx|Tx)\s+(\d+)\s+(\w+)\s+(s|x|sr|xr)\s+(\d+)\s*(.*)")
_DAY_NS = 86_400 * 10**9


def recognises(head: bytes) -> bool:
    """By its first line."""
    return head.startswith(b"***BUSMASTER")


def read(source: Source) -> Iterator[LogBatch]:
    """Frames; a fault for each line below the head that is none."""
    return read_lines(source, _Parser(source).entry)


class _Parser:
    """One file's lines."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._base = 16
        self._midnight_ns = 0
        self._latest_ns = 0

    def entry(self, line: str) -> LogEntry | None:
        """The line's entry; raises BadText, BadFrame, ValueError for one that is wrong."""
        if line.startswith("***"):
            self._head(line)
            return None
        if not line.strip():
            return None
        found = _LINE.fullmatch(line.strip())
        if found is None:
            raise BadText(f"{line[:100]!r} is no line of BUSMASTER")
        data = bytes(int(byte, self._base) for byte in found[10].split())
        length, remote = int(found[9]), "r" in found[8]
        if not remote and len(data) != length:
            raise BadText(f"length {length}, but {len(data)} bytes")
        time_ns = self._time(found)
        frame = Frame(
            int(found[7].removeprefix("0x"), self._base),
            b"" if remote else data,
            extended="x" in found[8],
            remote=remote,
            fd=length > 8,
            dlc=length if remote else None,
            timestamp_ns=time_ns,
        )
        return LogEntry(time_ns, f"can{found[6]}", frame, "R" if found[5] == "Rx" else "T")

    def _time(self, found: re.Match[str]) -> int:
        hour, minute, second = (int(found[number]) for number in (1, 2, 3))
        rest = int(found[4].ljust(9, "0")) if len(found[4]) > 3 else int(found[4]) * 1_000_000
        time_ns = self._midnight_ns + (hour * 3600 + minute * 60 + second) * 10**9 + rest
        if time_ns < self._latest_ns - _DAY_NS // 2:  # past midnight
            self._midnight_ns += _DAY_NS
            time_ns += _DAY_NS
        self._latest_ns = time_ns
        return time_ns

    def _head(self, line: str) -> None:
        if found := _START.match(line):
            day, month, year, hour, minute, second, milli = (int(word) for word in found.groups())
            begin = datetime(year, month, day, hour, minute, second, milli * 1000)
            self._source.start_ns = ns_of(begin)
            self._source.dated = True
            self._midnight_ns = ns_of(begin.replace(hour=0, minute=0, second=0, microsecond=0))
        elif line.startswith("***DEC***"):
            self._base = 10
