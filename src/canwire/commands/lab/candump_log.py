"""A candump log read twice: once to learn what it asks of a bus, once to play it.

Nothing is kept of it but counts and identifiers, so a log may be larger than memory.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import BinaryIO

from canwire import BadText, Frame, LogLine, parse_log_line
from canwire.commands.console import complain
from canwire.commands.lab.trace_cost import bits_of

_WIDEST = 200
_SHOWN = 10  # broken lines of a log, one by one
_LONGEST_NS = 100 * 365 * 86_400 * 1_000_000_000  # well inside the timeline's 63 bits


@dataclass(slots=True)
class Survey:
    """What a log contains.

    `channels` has the number of frames of each channel; `keys` are (extended, identifier) in order of appearance;
    `first_ns` is the first time stamp; `fd_line` is the number of the first line with a CAN FD frame, or None; `bits`
    is the approximate number of bits that the frames take on a bus.
    """

    channels: dict[str, int] = field(default_factory=dict)
    lines: int = 0
    frames: int = 0
    broken_lines: int = 0
    error_frames: int = 0
    first_ns: int = 0
    fd_line: int | None = None
    bits: int = 0
    keys: dict[tuple[bool, int], None] = field(default_factory=dict)

    def note(self, number: int, frame: Frame, channel: str) -> None:
        """Count a frame that will be played."""
        if not self.frames:
            self.first_ns = frame.timestamp_ns
        self.frames += 1
        self.channels[channel] = self.channels.get(channel, 0) + 1
        self.bits += bits_of(frame)
        self.keys[frame.extended, frame.id] = None
        if frame.fd and self.fd_line is None:
            self.fd_line = number


class Complaints:
    """Shows the first broken lines of a log on stderr, and how many more there are."""

    def __init__(self, path: str) -> None:
        self._path = path
        self._lines: list[tuple[str, str]] = []
        self._count = 0

    def add(self, number: int, what: str) -> None:
        self.add_at(str(number), what)

    def add_at(self, where: str, what: str) -> None:
        """The same for a place that is no line: "byte 4096"."""
        self._count += 1
        if self._count <= _SHOWN:
            self._lines.append((where, what))

    def show(self, found: Survey) -> None:
        """Raises BadText for a file without any line of a log: that is another kind of file."""
        if self._count and not found.frames + found.error_frames:
            number, what = self._lines[0]
            raise BadText(f"{self._path} is no candump log; line {number}: {_clipped(what)}")
        for number, what in self._lines:
            complain(f"{self._path}:{number}: {_clipped(what)}")
        if self._count > _SHOWN:
            complain(f"{self._path}: {self._count - _SHOWN} more broken lines")


def _clipped(what: str) -> str:
    """Fit for a terminal, whatever the file holds."""
    shown = "".join(one if one.isprintable() else "\N{REPLACEMENT CHARACTER}" for one in what)
    return shown if len(shown) <= _WIDEST else f"{shown[:_WIDEST]}..."


class CandumpLog:
    """One log file; "-" is standard input. What cannot be read twice goes into a temporary file first.

    A context manager. Raises OSError like `open`.
    """

    def __init__(self, path: str, wanted: Callable[[Frame], bool] | None = None) -> None:
        self._wanted = wanted
        self._closing = ExitStack()
        self._file: BinaryIO = self._open(path)

    def survey(self, complaints: Complaints) -> Survey:
        """Read all of it and show its broken lines; empty lines are no lines. Raises BadText for no log at all."""
        found = Survey()
        for number, content in self._contents():
            found.lines = number
            if isinstance(content, BadText):
                found.broken_lines += 1
                complaints.add(number, str(content))
            elif not isinstance(content.content, Frame):
                found.error_frames += 1
            elif self._wanted is None or self._wanted(content.content):
                found.note(number, content.content, content.interface)
        complaints.show(found)
        return found

    def frames(self) -> Iterator[tuple[int, Frame, str]]:
        """Line number, frame (its time stamp is the line's) and channel, from the beginning."""
        for number, content in self._contents():
            if not isinstance(content, LogLine) or not isinstance(content.content, Frame):
                continue
            if self._wanted is None or self._wanted(content.content):
                yield number, content.content, content.interface

    def _contents(self) -> Iterator[tuple[int, LogLine | BadText]]:
        self._file.seek(0)
        latest_ns: int | None = None
        for number, raw in enumerate(self._file, 1):
            text = raw.decode("utf-8", "replace").rstrip("\r\n")
            if not text.strip():
                continue
            try:
                content = parse_log_line(text)
                if latest_ns is None:
                    latest_ns = content.timestamp_ns + _LONGEST_NS
                elif content.timestamp_ns > latest_ns:
                    raise BadText(f"{text!r}: more than a century after the log's first time stamp")
                yield number, content
            except BadText as error:
                yield number, error

    def _open(self, path: str) -> BinaryIO:
        if path == "-":
            source: BinaryIO = sys.stdin.buffer
        else:
            source = self._closing.enter_context(open(path, "rb"))  # noqa: SIM115
        if source.seekable():
            return source
        copy = self._closing.enter_context(tempfile.TemporaryFile())  # noqa: SIM115
        shutil.copyfileobj(source, copy)
        return copy

    def __enter__(self) -> CandumpLog:
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.close()
