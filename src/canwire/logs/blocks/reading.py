"""Reads blocks of whole lines: plain lines become records together; batches keep the order of all entries."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Protocol

from canwire.logs.batch import LogBatch, batch_of, log_dtype
from canwire.logs.blocks.fields import Fields
from canwire.logs.entry import LogEntry
from canwire.logs.lines import lines_of, parsed_line
from canwire.logs.source import Source
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

_CHUNK = 1 << 20  # bytes: some 20,000 lines
_MOST_PARTS = 64  # of a block: with more of them, each line is read by itself


class LineReader(Protocol):
    """What a format must provide to read lines. A line may change how later lines are read."""

    separator: int | None
    """Of fields; None: blanks."""

    def entry(self, line: str) -> LogEntry | None:
        """Return the entry of one line, None if it has none; raises BadText, BadFrame, ValueError, LookupError if
        invalid."""

    def changing(self, fields: Fields) -> Any:
        """Select the lines that may change how other lines are read; they are never plain."""

    def candidates(self, fields: Fields) -> Any:
        """Select the lines that may be plain, by the lines read so far."""

    def records(self, fields: Fields, those: Any) -> tuple[numpy.ndarray, Any, Any]:
        """Parse candidates: returns records, a mask of those that are really plain, and the keys of their channels."""

    def name(self, key: Any) -> str:
        """Return the name of the channel with this key."""


def read_blocks(source: Source, reader: LineReader) -> Iterator[LogBatch]:
    """Read all lines of a file block by block; yields one batch for each block with entries."""
    number = 1
    for text in blocks(source):
        records, count = read_block(source, reader, text, number)
        if len(records):
            yield LogBatch(records, source.channels)
        number += count


def blocks(source: Source) -> Iterator[bytes]:
    """Yield blocks of whole lines; a line that is too long is cut as `readline` cuts it."""
    rest, longest = b"", source.limits.line_bytes
    while chunk := source.file.read(_CHUNK):
        text = rest + chunk
        end = text.rfind(b"\n") + 1
        end += (len(text) - end) // longest * longest
        if end:
            yield text[:end]
        rest = text[end:]
    if rest:
        yield rest


def read_block(source: Source, reader: LineReader, text: bytes, number: int) -> tuple[numpy.ndarray, int]:
    """Read some lines, the first of which has this number; returns their records and the number of lines."""
    numpy = load_numpy()
    fields = Fields(text, reader.separator)
    changing = reader.changing(fields)
    edges = (numpy.flatnonzero(numpy.diff(changing)) + 1).tolist()
    if (
        len(edges) > _MOST_PARTS
        or int((fields.line_ends - fields.line_begins).max()) >= source.limits.line_bytes
    ):
        return _line_by_line(source, reader, text, number)
    block = _Block(source, reader, fields, number)
    parts = [block.read(begin, end) for begin, end in zip([0, *edges], [*edges, len(fields)], strict=True)]
    return numpy.concatenate(parts), len(fields)


class _Block:
    """The lines of a block; line 0 of the block is line `number` of the file."""

    def __init__(self, source: Source, reader: LineReader, fields: Fields, number: int) -> None:
        self._source = source
        self._reader = reader
        self._fields = fields
        self._number = number

    def read(self, begin: int, end: int) -> numpy.ndarray:
        """Return records of the lines from `begin` to `end`, none of which changes how the others are read."""
        numpy = load_numpy()
        candidates = self._reader.candidates(self._fields) & self._fields.clean
        those = keys = begin + numpy.flatnonzero(candidates[begin:end])
        records = numpy.zeros(0, log_dtype())
        if len(those):
            records, good, keys = self._reader.records(self._fields, those)
            those, records, keys = those[good], records[good], keys[good]
        plain = numpy.zeros(end - begin, bool)
        plain[those - begin] = True
        lines, entries = [], []
        for line in (begin + numpy.flatnonzero(~plain)).tolist():
            raw = self._fields.line(line)
            entry = parsed_line(self._source, self._reader.entry, self._number + line, raw)
            if entry is not None:
                lines.append(line)
                entries.append(entry)
        records["channel"] = self._numbers(those, keys, lines, entries)
        if not entries:
            return records
        more = batch_of(entries, self._source.channels).records
        return numpy.insert(records, numpy.searchsorted(those, lines), more)

    def _numbers(self, those: Any, keys: Any, lines: list[int], entries: list[LogEntry]) -> Any:
        """Return the channels' numbers for the plain lines; new names are numbered in the order of all lines."""
        numpy = load_numpy()
        if not len(keys):
            different, first, which = keys, [], keys
        elif (keys == keys[0]).all():
            different, first, which = keys[:1], [0], numpy.zeros(len(keys), "i8")
        else:
            different, first, which = numpy.unique(keys, return_index=True, return_inverse=True)
        names = [self._reader.name(key) for key in different]
        met = [(int(those[at]), name) for at, name in zip(first, names, strict=True)]
        seen: set[str] = set()
        for line, entry in zip(lines, entries, strict=True):
            if entry.channel not in seen:
                seen.add(entry.channel)
                met.append((line, entry.channel))
        for _, name in sorted(met):
            self._source.channel(name)
        return numpy.array([self._source.channel(name) for name in names], "u2")[which] if names else which


def _line_by_line(source: Source, reader: LineReader, text: bytes, number: int) -> tuple[numpy.ndarray, int]:
    """Read some lines one by one, without the check for plain lines; returns their records and the number of lines."""
    entries, count = [], 0
    for raw in lines_of(text, source.limits.line_bytes):
        entry = parsed_line(source, reader.entry, number + count, raw)
        count += 1
        if entry is not None:
            source.channel(entry.channel)
            entries.append(entry)
    found = batch_of(entries, source.channels).records if entries else load_numpy().zeros(0, log_dtype())
    return found, count
