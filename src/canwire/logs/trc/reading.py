"""Reads TRC: the file's version or header defines the columns; the most common lines are read with numpy (plain.py)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from canwire.errors import BadText
from canwire.logs.batch import LogBatch
from canwire.logs.blocks.fields import Fields
from canwire.logs.blocks.reading import read_blocks
from canwire.logs.dates import ns_of_ole
from canwire.logs.entry import LogEntry
from canwire.logs.source import Source
from canwire.logs.trc import plain
from canwire.logs.trc.codes import FD_TYPES, error_of_columns, event_of_status
from canwire.values.dlc import FD_LENGTHS
from canwire.values.event import BusEvent, EventKind
from canwire.values.frame import Frame

if TYPE_CHECKING:
    import numpy

_COLUMNS = {  # where a head names none: Y is the type of versions 1, with the direction in it
    "1.0": "N,O,I,L,D",
    "1.1": "N,O,Y,I,L,D",
    "1.2": "N,O,B,Y,I,L,D",
    "1.3": "N,O,B,Y,I,R,L,D",
    "2.0": "N,O,T,I,d,l,D",
    "2.1": "N,O,T,B,I,d,R,l,D",
}
_VERSION_1_LINE = re.compile(rb"\s*\d+\)\s+\d+(\.\d+)?\s")


def recognises(head: bytes) -> bool:
    """Recognises the format by `;$FILEVERSION`, or by numbered lines below comments (version 1.0)."""
    if b";$FILEVERSION" in head:
        return True
    lines = [line for line in head.splitlines() if line.strip()]
    numbered = [line for line in lines if not line.startswith(b";")]
    return (
        bool(lines)
        and lines[0].startswith(b";")
        and bool(numbered)
        and bool(_VERSION_1_LINE.match(numbered[0]))
    )


def read(source: Source) -> Iterator[LogBatch]:
    """Yield frames, remote frames, error frames, changes of state and of error counters."""
    return read_blocks(source, _Parser(source))


class _Parser:
    """Parses the lines of one file."""

    separator: int | None = None

    def __init__(self, source: Source) -> None:
        self._source = source
        self._zero_ns = 0
        self._columns = _COLUMNS["1.0"].split(",")

    def entry(self, line: str) -> LogEntry | None:
        """Return the entry of this line; raises BadText, BadFrame, ValueError for an invalid line."""
        text = line.strip()
        if text.startswith(";"):
            self._head(text)
            return None
        if not text:
            return None
        words = text.split(maxsplit=len(self._columns) - 1)
        if len(words) < len(self._columns) - 1:
            raise BadText(f"{text[:100]!r}: {len(words)} columns of {len(self._columns)}")
        return self._row(dict(zip(self._columns, [*words, ""], strict=False)))

    def changing(self, fields: Fields) -> Any:
        return plain.changing(fields)

    def candidates(self, fields: Fields) -> Any:
        """Select the lines that may be plain; none if the times of the file are out of range."""
        return plain.candidates(fields, self._columns) & (abs(self._zero_ns) < 1 << 62)

    def records(self, fields: Fields, those: Any) -> tuple[numpy.ndarray, Any, Any]:
        return plain.records(fields, those, self._columns, self._zero_ns)

    def name(self, key: Any) -> str:
        """Return the name of the channel with this number."""
        return f"can{max(int(key) - 1, 0)}"

    def _head(self, text: str) -> None:
        name, _, value = text.partition("=")
        if name == ";$FILEVERSION":
            if value.strip() not in _COLUMNS:
                raise BadText(f"version {value.strip()}: known are {', '.join(_COLUMNS)}")
            self._columns = _COLUMNS[value.strip()].split(",")
        elif name == ";$COLUMNS":
            self._columns = [column.strip() for column in value.split(",")]
        elif name == ";$STARTTIME" and float(value):
            self._zero_ns = self._source.start_ns = ns_of_ole(float(value))
            self._source.dated = True

    def _row(self, row: dict[str, str]) -> LogEntry | None:
        millis, _, decimals = row["O"].partition(".")
        span = abs(int(millis)) * 1_000_000 + int((decimals or "0").ljust(6, "0")[:6])
        time_ns = self._zero_ns + (-span if millis.startswith("-") else span)
        if not 0 <= time_ns < 1 << 63:
            raise BadText(f"time offset {row['O']}: past all clocks")
        channel = f"can{max(int(row.get('B', '1')) - 1, 0)}"
        kind, direction = self._kind(row)
        if kind in ("ER", "ST", "EC"):
            return LogEntry(time_ns, channel, _event(kind, row, time_ns))
        if kind in ("DT", "RR", *FD_TYPES):
            return LogEntry(time_ns, channel, _frame(kind, row, time_ns), direction)
        if kind == "EV":
            return None
        raise BadText(f"type {kind!r}: not known")

    def _kind(self, row: dict[str, str]) -> tuple[str, str | None]:
        """Return the type by its name in version 2, and the direction."""
        if "T" in row:
            return row["T"], {"Rx": "R", "Tx": "T"}.get(row.get("d", ""))
        told = row.get("Y", "")
        if told == "Warng" or row["I"] == "FFFFFFFF":
            return "ST", None
        if told == "Error" or row["D"].startswith("ERROR"):
            row["D"] = row["D"].removeprefix("ERROR").strip()
            return "ER", None
        return "RR" if row["D"].startswith("RTR") else "DT", {"Rx": "R", "Tx": "T"}.get(told)


def _frame(kind: str, row: dict[str, str], time_ns: int) -> Frame:
    fd = kind in FD_TYPES
    length = int(row["l"] if "l" in row else row["L"])
    remote = kind == "RR"
    if "l" in row:
        dlc = FD_LENGTHS.index(length) if length in FD_LENGTHS else -1
    else:
        dlc = length
    count = 0 if remote else FD_LENGTHS[dlc] if fd else min(dlc, 8)
    data = bytes(int(byte, 16) for byte in row["D"].split()[:count])
    if len(data) < count:
        raise BadText(f"length {length}, but {len(data)} bytes")
    brs, esi = FD_TYPES.get(kind, (False, False))
    return Frame(
        int(row["I"], 16),
        data,
        extended=len(row["I"]) > 4,
        remote=remote,
        fd=fd,
        bit_rate_switch=brs,
        error_state_indicator=esi,
        dlc=dlc,
        timestamp_ns=time_ns,
    )


def _event(kind: str, row: dict[str, str], time_ns: int) -> BusEvent:
    words = row["D"].split()
    data = bytes(int(byte, 16) for byte in words[:4] if len(byte) == 2)
    if kind == "ER":
        return error_of_columns(int(row["I"], 16), data, time_ns)
    if kind == "EC":
        rec, tec = data[:2]
        return BusEvent(EventKind.STATE, time_ns, rec=rec, tec=tec)
    return event_of_status(data, time_ns)
