"""Reads candump logs: most lines together with numpy (fast.py), the rest one by one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from canwire.errors import BadText
from canwire.logs.batch import LogBatch, log_dtype
from canwire.logs.blocks.reading import blocks
from canwire.logs.entry import LogEntry
from canwire.logs.source import Source
from canwire.values.lin.text import parse_lin_log_line
from canwire.values.record import load_numpy
from canwire.values.screen_text import parse_candump_line
from canwire.values.text import parse_log_line

if TYPE_CHECKING:
    import numpy

_CENTURY_NS = 100 * 365 * 86_400 * 10**9
_LOG = re.compile(rb"\s*\( *\d+\.\d+\)\s+\S+\s+[0-9A-Za-z_]+#")
_SCREEN = re.compile(
    rb"\s*(?:\(\d[\d.: -]*\)\s+)?[^\s()]+\s+(?:[RT]X [B-] [E-]\s+)?"
    rb"(?:[0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})\s+(?:\[\d{1,2}\]|\{.\})"
)
_LOOKED_AT = 40  # lines of a beginning


def recognises(head: bytes) -> bool:
    """Recognises the format if any of the first lines is a log or screen line: the first line may be incomplete."""
    lines = head.splitlines()[:_LOOKED_AT]
    return any(_LOG.match(line) or _SCREEN.match(line) for line in lines)


def entries(source: Source) -> Iterator[LogEntry]:
    """Yield the entries one by one, without numpy."""
    parser = LineParser(source)
    number = 0
    while raw := source.file.readline(source.limits.line_bytes):
        number += 1
        entry = parser.entry(number, raw)
        if entry is not None:
            yield entry


def read(source: Source) -> Iterator[LogBatch]:
    """Yield batches of some ten thousand lines each."""
    from canwire.logs.candump.fast import plain_lines

    load_numpy()
    parser = LineParser(source)
    number = 1
    for text in blocks(source):
        records, others, count = plain_lines(text, source)
        yield LogBatch(_merged(records, others, number, parser), source.channels)
        number += count


def _merged(
    records: numpy.ndarray, others: list[tuple[int, int, bytes]], first: int, parser: LineParser
) -> numpy.ndarray:
    """Merge the records of plain lines with the entries of other lines, in the order of the file."""
    numpy = load_numpy()
    parser.check_times(records)
    places, found = [], []
    for place, line, raw in others:
        entry = parser.entry(first + line, raw)
        if entry is not None:
            places.append(place)
            found.append(entry)
    if not found:
        return records
    more = parser.source.batch(found).records
    return numpy.insert(records, places, more) if len(records) else more.astype(log_dtype())


class LineParser:
    """Converts lines to entries; an invalid line is a fault of the source."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self._latest_ns: int | None = None

    def entry(self, number: int, raw: bytes) -> LogEntry | None:
        """Return the entry of this line; None for empty lines, comments and faults."""
        text = raw.decode("utf-8", "replace").rstrip("\r\n")
        if not text.strip() or text.startswith("#"):
            return None
        try:
            found = _parsed(text)
            self._check_time(found.timestamp_ns, text)
        except BadText as error:
            self.source.fault(f"line {number}", str(error))
            return None
        self.source.channel(found.channel)
        return found

    def check_times(self, records: numpy.ndarray) -> None:
        """Find out from the time of the first record whether the log is dated."""
        if len(records) and self._latest_ns is None:
            self._begin(int(records["time_ns"][0]))

    def _begin(self, first_ns: int) -> None:
        self._latest_ns = first_ns + _CENTURY_NS
        self.source.infer_date(first_ns)

    def _check_time(self, time_ns: int, text: str) -> None:
        if self._latest_ns is None:
            self._begin(time_ns)
        elif time_ns > self._latest_ns:
            raise BadText(f"{text[:120]!r}: more than a century after the log's first time stamp")


def _parsed(text: str) -> LogEntry:
    """Return the entry of a log line of CAN or LIN, or of a screen line; raises BadText of the most similar format."""
    try:
        return LogEntry(*parse_log_line(text))
    except BadText as error:
        if _SCREEN.match(text.encode()):  # -a shows the data, which may be a #
            return LogEntry(*parse_candump_line(text))
        try:
            return LogEntry(*parse_lin_log_line(text))
        except BadText:
            raise error from None
