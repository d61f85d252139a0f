"""Logs that are lines of text: what their readers share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from canwire.errors import BadFrame, BadText
from canwire.logs.batch import LogBatch
from canwire.logs.entry import LogEntry
from canwire.logs.source import Source

_AT_ONCE = 20_000
_LONGEST = 1 << 16  # of a line: longer ones are no text


def read_lines(source: Source, parse: Callable[[str], LogEntry | None]) -> Iterator[LogBatch]:
    """Batches of what `parse` makes of each line: None for one that is no entry; its errors are the source's faults."""
    found: list[LogEntry] = []
    number = 0
    while raw := source.file.readline(_LONGEST):
        number += 1
        try:
            entry = parse(raw.decode("utf-8", "replace").rstrip("\r\n"))
        except (BadFrame, BadText, ValueError, IndexError, KeyError, OverflowError) as error:
            source.fault(f"line {number}", _short(str(error)))
            continue
        if entry is not None:
            source.channel(entry.channel)
            found.append(entry)
        if len(found) >= _AT_ONCE:
            yield source.batch(found)
            found = []
    if found:
        yield source.batch(found)


def _short(text: Any) -> str:
    return text if len(text) <= 200 else f"{text[:200]}..."


def number_of(channel: str, channels: list[str]) -> int:
    """A channel's number from 1 on, for formats that have numbers: its place among the names."""
    return channels.index(channel) + 1
