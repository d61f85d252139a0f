r"""Traces of CARBUS Analyzer (CAN-Hacker), read only: `27,337000\t1\t00000004\t3D8\t8\t00 00 04 ...\t00000000\t`.

The columns are the time (seconds and, in version 2, milliseconds, in version 3 microseconds), channel, flags in hex,
identifier in hex, length, data, checksum and text. Lines may end by a carriage return alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice

from canwire.errors import BadText
from canwire.logs.batch import LogBatch
from canwire.logs.entry import LogEntry
from canwire.logs.lines import parsed_line
from canwire.logs.source import Source
from canwire.values.frame import Frame

_AT_ONCE = 20_000
_EXTENDED, _REMOTE, _FD, _BRS = 0x01, 0x02, 0x10, 0x20
_HEAD = re.compile(r"@ TEXT @ (\d+) @")
_END = re.compile(rb"\r\n?|\n")


def recognises(head: bytes) -> bool:
    """Recognised by the first line."""
    return head.upper().startswith(b"@ TEXT @")


def read(source: Source) -> Iterator[LogBatch]:
    """Yields frames; each other line below the head is a fault."""
    entries = _entries(source)
    while found := list(islice(entries, _AT_ONCE)):
        yield source.batch(found)


def _entries(source: Source) -> Iterator[LogEntry]:
    parser = _Parser()
    for number, line in enumerate(_lines(source), 1):
        entry = parsed_line(source, parser.entry, number, line)
        if entry is not None:
            yield entry


def _lines(source: Source) -> Iterator[bytes]:
    """Yield the lines of the file. A two-byte end of line across two blocks yields an extra empty line, which is
    ignored."""
    left = b""
    while block := source.file.read(source.limits.line_bytes):
        *lines, left = _END.split(left + block)
        yield from lines
    yield left


class _Parser:
    """Parses the lines of one file."""

    def __init__(self) -> None:
        self._unit_ns = 1000

    def entry(self, line: str) -> LogEntry | None:
        """Return the entry of this line; raises BadText, BadFrame, ValueError for an invalid line."""
        if head := _HEAD.match(line.upper()):
            self._unit_ns = 1_000_000 if int(head[1]) <= 2 else 1000
            return None
        if not line.strip() or line.startswith("#"):
            return None
        time, channel, flagged, id, length, text, *_ = line.split("\t")
        seconds, _, rest = time.partition(",")
        time_ns = int(seconds) * 10**9 + int(rest or "0") * self._unit_ns
        flags, remote = int(flagged, 16), bool(int(flagged, 16) & _REMOTE)
        data = b"" if remote else bytes.fromhex(text)
        if not remote and len(data) != int(length):
            raise BadText(f"length {length}, but {len(data)} bytes")
        frame = Frame(
            int(id, 16),
            data,
            extended=bool(flags & _EXTENDED),
            remote=remote,
            fd=bool(flags & _FD),
            bit_rate_switch=bool(flags & _FD and flags & _BRS),
            dlc=int(length) if remote else None,
            timestamp_ns=time_ns,
        )
        return LogEntry(time_ns, f"can{int(channel) - 1}", frame)
