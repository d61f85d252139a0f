"""Logs of Microchip's CAN BUS Analyzer, read only: `166064;RX;0x0000021A;8;0xFE;0x36;0x12;0xFE;0x69;0x05;0x07;0xAD;`.

Times are milliseconds from an unknown zero. An identifier above 7FF has 29 bits, since the file does not mark them.
"""

from __future__ import annotations

from collections.abc import Iterator

from canwire.errors import BadText
from canwire.logs.batch import LogBatch
from canwire.logs.entry import LogEntry
from canwire.logs.lines import read_lines
from canwire.logs.source import Source
from canwire.values.frame import Frame

_DIRECTIONS = {"RX": "R", "TX": "T"}


def recognises(head: bytes) -> bool:
    """Recognised by the head, which is between two comment lines."""
    return head.startswith(b"//") and b"Microchip Technology" in head[:300]


def read(source: Source) -> Iterator[LogBatch]:
    """Yields frames; each other line below the head is a fault."""
    return read_lines(source, _Parser().entry)


class _Parser:
    """Parses the lines of one file. A line of // begins a comment, and the next such line ends it."""

    def __init__(self) -> None:
        self._comment = False

    def entry(self, line: str) -> LogEntry | None:
        """Return the entry of this line; raises BadText, BadFrame, ValueError for an invalid line."""
        if line.startswith("//"):
            self._comment = not self._comment
            return None
        if self._comment or not line.strip():
            return None
        time_ms, direction, id, length, *data = (cell.strip() for cell in line.rstrip("; ").split(";"))
        if len(data) != int(length):
            raise BadText(f"length {length}, but {len(data)} bytes")
        number, time_ns = int(id, 0), int(time_ms) * 1_000_000
        frame = Frame(
            number, bytes(int(byte, 0) for byte in data), extended=number > 0x7FF, timestamp_ns=time_ns
        )
        return LogEntry(time_ns, "can0", frame, _DIRECTIONS.get(direction.upper()))
