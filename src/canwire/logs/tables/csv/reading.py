"""Reads CSV block by block: canwire's rows with numpy (plain.py), all others with the csv module.

A quoted cell may continue in the next line, possibly in the next block: from such a row on the csv module reads.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator
from functools import partial
from itertools import chain, islice
from typing import TYPE_CHECKING, Any

from canwire.errors import BadFrame, BadText
from canwire.logs.batch import LogBatch
from canwire.logs.blocks.fields import Fields
from canwire.logs.blocks.reading import blocks, read_block
from canwire.logs.entry import LogEntry
from canwire.logs.source import Source
from canwire.logs.tables.csv import plain
from canwire.logs.tables.csv.named import dialect_of
from canwire.logs.tables.csv.rows import GVRET, HEADER, PYTHON_CAN, Parse, parser_of, row_of_ours
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

_AT_ONCE = 20_000
OTHERS = (HEADER, PYTHON_CAN, GVRET)
"""Headers whose rows are known; others tell by names what their columns are."""


def recognises(head: bytes) -> bool:
    """Recognises the format by the header line."""
    text = head.decode("utf-8", "replace").lstrip("\ufeff")
    return text.startswith(OTHERS) or dialect_of(text.partition("\n")[0]) is not None


def read(source: Source) -> Iterator[LogBatch]:
    """Yield batches of some ten thousand rows; an invalid row is a fault."""
    header = source.file.readline(source.limits.line_bytes)
    told = header.decode("utf-8-sig", "replace")
    texts = blocks(source)
    named = None if told.startswith(OTHERS) else dialect_of(told)
    if named is not None:
        yield from _read_rows(source, chain([header], texts), named[1].entry, 0, named[0])
        return
    parse = parser_of(told)
    simple = header.endswith(b"\n") and b'"' not in header and b"\r" not in header.rstrip(b"\r\n")
    if not simple or parse is not row_of_ours:
        yield from _read_rows(source, chain([header], texts), parse, 0)
        return
    number = 2
    for text in texts:
        if not _is_line_by_line(text, source.limits.line_bytes):
            yield from _read_rows(source, chain([text], texts), parse, number)
            return
        records, count = read_block(source, _Reader(), text, number)
        number += count
        if len(records):
            source.infer_date(int(records["time_ns"][0]))
            yield LogBatch(records, source.channels)


class _Reader:
    """Parses canwire's rows, each of which is a line."""

    separator: int | None = ord(",")

    def entry(self, line: str) -> LogEntry | None:
        """Return the row's entry; raises BadText, BadFrame, ValueError, IndexError."""
        try:
            row = next(csv.reader([_without_nul(line)]), [])
        except csv.Error as error:
            raise BadText(str(error)) from None
        return row_of_ours(row) if row else None

    def changing(self, fields: Fields) -> Any:
        return fields.count < 0

    def candidates(self, fields: Fields) -> Any:
        return plain.candidates(fields)

    def records(self, fields: Fields, those: Any) -> tuple[numpy.ndarray, Any, Any]:
        return plain.records(fields, those)

    def name(self, key: Any) -> str:
        """Return a channel's name from its bytes."""
        return bytes(key).decode("ascii")


def _is_line_by_line(text: bytes, longest: int) -> bool:
    """Whether each line is one row: no line is cut or ends with a lone carriage return, no cell continues in the next
    line."""
    if text.count(b"\r") != text.count(b"\r\n"):
        return False
    numpy = load_numpy()
    block = numpy.frombuffer(text, "u1")
    ends = numpy.append(numpy.flatnonzero(block == 10), len(text))
    if int(numpy.diff(ends, prepend=-1).max()) > longest:
        return False
    if b'"' not in text:
        return True
    quoted = numpy.unique(numpy.searchsorted(ends, numpy.flatnonzero(block == 34)))
    begins = numpy.append(0, ends[:-1] + 1)
    lines = (text[begins[line] : ends[line]].decode("latin-1") for line in quoted.tolist())
    return all(_is_row(line) for line in lines)


def _is_row(line: str) -> bool:
    """Whether the line is a complete row, so that a line after it is another row."""
    try:
        return sum(1 for _ in csv.reader([_without_nul(line) + "\n", "behind"])) == 2
    except csv.Error:
        return False


def _read_rows(
    source: Source, texts: Iterable[bytes], parse: Parse, number: int, delimiter: str = ","
) -> Iterator[LogBatch]:
    """Yield batches from the csv module; the first row has this number. Number 0: the rows begin with the header."""
    pieces = io.BufferedReader(_Pieces(iter(texts)))
    text = io.TextIOWrapper(pieces, "utf-8-sig", errors="replace", newline="")
    lines = iter(partial(text.readline, source.limits.line_bytes), "")
    rows = csv.reader(map(_without_nul, lines), delimiter=delimiter)
    if not number:
        header, number = ",".join(next(rows, [])), 2
        parse = parser_of(header) if header.startswith(OTHERS) else parse
    entries = _entries(source, rows, parse, number)
    while batch := list(islice(entries, _AT_ONCE)):
        source.infer_date(batch[0].timestamp_ns)
        yield source.batch(batch)


def _entries(source: Source, rows: Iterator[list[str]], parse: Parse, number: int) -> Iterator[LogEntry]:
    while True:
        try:
            row = next(rows)
            if row:
                yield parse(row)
        except StopIteration:
            return
        except (BadFrame, BadText, ValueError, IndexError, csv.Error) as error:
            source.fault(f"line {number}", str(error))
        number += 1


def _without_nul(line: str) -> str:
    return line.replace("\0", "\N{REPLACEMENT CHARACTER}")


class _Pieces(io.RawIOBase):
    """A file that consists of pieces of bytes."""

    def __init__(self, texts: Iterator[bytes]) -> None:
        self._texts = texts
        self._left = memoryview(b"")

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        while not self._left:
            text = next(self._texts, None)
            if text is None:
                return 0
            self._left = memoryview(text)
        count = min(len(buffer), len(self._left))
        buffer[:count], self._left = self._left[:count], self._left[count:]
        return count
