"""The contents of a row, as text."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import NamedTuple

from canwire import BadValue
from canwire.commands.dump.filters import Capture, parse_capture
from canwire.commands.live.decoding import Decode
from canwire.commands.view.table import Row


class Texts(NamedTuple):
    """The texts of one row. `data` is bytes in hex with blanks between, or the text in place of them; periods in ms."""

    line: str
    id: str
    length: str
    data: str
    frames: str
    period: str
    least: str
    most: str
    decoded: str


TITLES = Texts("line", "id", "len", "data", "count", "period ms", "min", "max", "")


def texts_of(row: Row, decode: Decode | None) -> Texts:
    """Return the columns of a row; `decode` gives names and signals."""
    frame = row.frame
    message = None if decode is None else decode(frame, row.key.line)
    return Texts(
        row.key.line,
        f"{frame.id:08X}" if frame.extended else f"{frame.id:03X}",
        f"{len(frame.data):02d}" if frame.fd else str(min(frame.dlc, 8)),
        "remote request" if frame.remote else frame.data.hex(" ").upper(),
        str(row.count),
        _ms(row.gap_ns),
        _ms(row.least_ns),
        _ms(row.most_ns),
        "" if message is None else str(message),
    )


def format_row(texts: Texts) -> str:
    """A plain line: `can0       123  8     120      10.0 (    9.8 ..    10.2)  11 22 33`"""
    decoded = f"  :: {texts.decoded}" if texts.decoded else ""
    return (
        f"{texts.line:<8} {texts.id:>8} {texts.length:>2} {texts.frames:>8} {texts.period:>9} "
        f"({texts.least:>7} ..{texts.most:>9})  {texts.data}{decoded}"
    )


def format_csv(every: Iterable[Texts]) -> str:
    """Return all rows as CSV, with titles."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*TITLES[:-1], "decoded"])
    writer.writerows(every)
    return text.getvalue()


class Wanted:
    """The text of the filter box: identifiers as in `canwire dump --filter`, or part of a name."""

    def __init__(self, text: str, decode: Decode | None) -> None:
        self._text = text.strip().lower()
        self._decode = decode
        self._capture: Capture | None = None
        with suppress(BadValue):  # no identifiers: a name
            self._capture = parse_capture([text.strip().replace(" ", "")], [], False)

    def accepts(self, row: Row) -> bool:
        if not self._text:
            return True
        frame = row.frame
        return (self._capture is not None and self._capture.accepts(frame)) or self._text in self._name(row)

    def _name(self, row: Row) -> str:
        message = None if self._decode is None else self._decode(row.frame, row.key.line)
        return "" if message is None else message.name.lower()


def widths_of(shown: Sequence[Texts]) -> list[int]:
    """Return the widths of the columns that these rows and the titles need."""
    return [max(map(len, column)) for column in zip(TITLES, *shown, strict=True)]


def _ms(gap_ns: int | None) -> str:
    return "" if gap_ns is None else f"{gap_ns / 1e6:.1f}"
