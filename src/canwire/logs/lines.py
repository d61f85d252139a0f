"""Functions for the readers of logs that are lines of text."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator

from canwire.errors import BadFrame, BadText
from canwire.logs.batch import LogBatch
from canwire.logs.entry import LogEntry
from canwire.logs.source import Source

_AT_ONCE = 20_000


def read_lines(source: Source, parse: Callable[[str], LogEntry | None]) -> Iterator[LogBatch]:
    """Batches of the entries from `parse` (None: no entry in the line); its errors become faults of the source."""
    found: list[LogEntry] = []
    number = 0
    while raw := source.file.readline(source.limits.line_bytes):
        number += 1
        entry = parsed_line(source, parse, number, raw)
        if entry is not None:
            source.channel(entry.channel)
            found.append(entry)
        if len(found) >= _AT_ONCE:
            yield source.batch(found)
            found = []
    if found:
        yield source.batch(found)


def parsed_line(
    source: Source, parse: Callable[[str], LogEntry | None], number: int, raw: bytes
) -> LogEntry | None:
    """The entry from `parse` for this line; an error becomes a fault of the source, with the number of the line."""
    try:
        return parse(raw.decode("utf-8", "replace").rstrip("\r\n"))
    except (BadFrame, BadText, ValueError, IndexError, KeyError, OverflowError) as error:
        text = str(error)
        source.fault(f"line {number}", text if len(text) <= 200 else f"{text[:200]}...")
        return None


def lines_of(text: bytes, longest: int) -> Iterator[bytes]:
    """Yield the lines of a text; lines that are too long are divided."""
    file = io.BytesIO(text)
    while raw := file.readline(longest):
        yield raw


def number_of(channel: str, channels: list[str]) -> int:
    """Return a channel's number for formats with numbers: its index in the names plus 1."""
    return channels.index(channel) + 1
