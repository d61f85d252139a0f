"""Reads logs: `open_log`."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any, BinaryIO, TypeVar, cast

from canwire.errors import BadLog, CanwireError, Closed
from canwire.forks import hear_of_forks, reopen
from canwire.logs.batch import LOG_RECORD_SIZE, LogBatch, entry_of
from canwire.logs.entry import LogEntry
from canwire.logs.formats import HEAD, LogFormat, format_named, format_of_file, load_format
from canwire.logs.journal import SUFFIX
from canwire.logs.limits import USUAL, LogLimits
from canwire.logs.packing import Unpacking, refuse_packed, unpacked, unpacked_name
from canwire.logs.source import LogFault, Source
from canwire.logs.trace.files import files_of
from canwire.values.checks import instance
from canwire.values.mistakes.calls import answers_wrong_calls

Read = TypeVar("Read", LogEntry, LogBatch)


class Log:
    """A log to read. Each iteration starts at the beginning; a stream can be read only once.

    Made by `open_log`; a context manager. Unreadable parts are left out and listed in `faults`.
    """

    def __init__(
        self,
        path: str,
        form: LogFormat,
        file: BinaryIO,
        closing: ExitStack,
        unpacking: Unpacking | None = None,
        raw: BinaryIO | None = None,
        limits: LogLimits = USUAL,
    ) -> None:
        self._form = form
        self._unpacking = unpacking
        self._closing: ExitStack | None = closing
        self._source = Source(path, file, limits)
        self._begun = False
        self._raw = raw
        self._left = False
        if raw is not None:
            hear_of_forks(self)

    @property
    def path(self) -> str:
        return self._source.path

    @property
    def format(self) -> str:
        """The name of its format: "candump", "blf"."""
        return self._form.name

    @property
    def channels(self) -> list[str]:
        """Names of the channels found so far, in their order."""
        return list(self._source.channels)

    @property
    def dated(self) -> bool:
        """Whether time stamps count from 1970 (UTC); known after the first entry was read."""
        return self._source.dated

    @property
    def start_ns(self) -> int | None:
        """When the log began, in nanoseconds since 1970: its header's date, or its first dated stamp; None: unknown."""
        return self._source.start_ns

    @property
    def clock(self) -> str:
        """The clock of the time stamps, if the log names it ("hub", "adapter"), else ""."""
        return self._source.clock

    @property
    def faults(self) -> list[LogFault]:
        """Parts that could not be read so far, with their places: the first thousand."""
        return list(self._source.faults)

    @property
    def fault_count(self) -> int:
        """The number of faults so far."""
        return self._source.fault_count

    def __iter__(self) -> Iterator[LogEntry]:
        """Yield every entry: frames, events, marks. `batches` is faster."""
        single = getattr(load_format(self._form), "entries", None)
        if single is None:
            for batch in self.batches():
                yield from self._entries(batch)
            return
        source, entry = self._rewound(), None
        for entry in self._read(single(source)):
            yield entry
        self._tell_problem(source)
        if entry is None:
            self._refuse(source)

    def batches(self) -> Iterator[LogBatch]:
        """The entries as numpy records, some ten thousands at a time. Needs canwire[arrays].

        Raises BadLog if the whole file contains nothing readable.
        """
        source = self._rewound()
        count = 0
        for batch in self._read(load_format(self._form).read(source)):
            if len(batch):
                count += len(batch)
                if source.dated and source.start_ns is None:
                    source.start_ns = int(batch.records["time_ns"][0])
                yield batch
        self._tell_problem(source)
        if not count:
            self._refuse(source)

    def close(self) -> None:
        """Close the file; a second call does nothing."""
        if self._closing is not None:
            self._closing.close()
            self._closing = None

    def __enter__(self) -> Log:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Log {self.path!r}, {self.format}>"

    def leave_to_parent(self) -> None:
        """In a forked process: continue independently of the parent, or not at all."""
        if self._raw is not None and not self._raw.closed:
            try:
                reopen(self._raw)
            except OSError:
                self._left = True

    def _read(self, found: Iterator[Read]) -> Iterator[Read]:
        """Yield the results of a reader. Its errors, other than those of canwire and the system, are faults of the
        file."""
        while True:
            try:
                each = next(found)
            except StopIteration:
                return
            except (CanwireError, OSError, MemoryError):
                raise
            except Exception as error:
                told = f"nothing more of it can be read as {self.format} ({type(error).__name__}: {error})"
                raise BadLog(f"{self.path}: {told[:300]}") from error
            yield each

    def _entries(self, batch: LogBatch) -> Iterator[LogEntry]:
        """Yield the batch's entries; an invalid record, in a damaged file, is a fault."""
        block = batch.records.tobytes()
        for at in range(0, len(block), LOG_RECORD_SIZE):
            try:
                yield entry_of(block[at : at + LOG_RECORD_SIZE], batch.channels)
            except (ValueError, LookupError) as error:
                self._source.fault("record", f"nothing that a log holds: {error}")

    def _tell_problem(self, source: Source) -> None:
        """Report a fault for a packed file that is incomplete."""
        if self._unpacking is not None and self._unpacking.problem:
            source.fault("end", self._unpacking.problem)

    def _refuse(self, source: Source) -> None:
        """Raise BadLog for a file that is not empty, but of which nothing could be read."""
        if source.faults:
            raise BadLog(f"{self.path}: nothing of it can be read as {self.format}; {source.faults[0]}")

    def _rewound(self) -> Source:
        if self._closing is None:
            raise Closed(f"log {self.path}")
        if self._left:
            raise CanwireError(f"log {self.path} belongs to the process that was forked; open it in this one")
        before = self._source
        if self._begun:
            if not before.file.seekable():
                raise BadLog(f"{self.path}: a stream, which can be read once only")
            before.file.seek(0)
            self._source = Source(before.path, before.file, before.limits)
        self._begun = True
        return self._source


@answers_wrong_calls
def open_log(path: str | os.PathLike[str], *, format: str | None = None, limits: LogLimits = USUAL) -> Log:
    """Open a log of any format, given by its first bytes or by `format`. "-" is standard input.

    >>> with open_log("drive.log") as log:  # doctest: +SKIP
    ...     for entry in log:
    ...         print(entry.timestamp_ns, entry.channel, entry.content)

    A folder is a trace. A file packed with gzip or Zstandard (canwire[parquet]) is unpacked while it is read. If the
    file does not exist, but the journal of a killed recording does, the journal is read.

    `limits` protect against untrusted files. Reading raises BadLog beyond these limits or if a damaged file cannot be
    read any further, and OSError.

    Raises BadLog for a file that is no log, BadValue for an unknown format, OSError if the file cannot be opened.
    """
    instance("path", path, str, os.PathLike)
    name = os.fspath(path)
    if name != "-" and not os.path.exists(name) and os.path.exists(name + SUFFIX):
        name, format = name + SUFFIX, "journal"
    with ExitStack() as closing:
        if os.path.isdir(name) and format in (None, "trace"):
            files_of(name)
            return Log(
                name, format_named("trace"), io.BytesIO(), closing.pop_all(), limits=limits
            )  # it opens its files itself
        file: Any = sys.stdin.buffer if name == "-" else closing.enter_context(open(name, "rb"))
        raw = file if name != "-" else None
        file, head = _peeked(file)
        file, unpacking = unpacked(name, file, head)
        if unpacking is not None:
            file, head = _peeked(file)
        form = format_named(format) if format is not None else format_of_file(unpacked_name(name), head)
        if unpacking is not None:
            refuse_packed(name, form.name)
        return Log(name, form, file, closing.pop_all(), unpacking, raw, limits)


def _peeked(file: BinaryIO) -> tuple[BinaryIO, bytes]:
    """Return the file and its first bytes, which can still be read from the file."""
    if file.seekable():
        head = file.read(HEAD)
        file.seek(0)
        return file, head
    reader = file if isinstance(file, io.BufferedReader) else io.BufferedReader(cast(Any, file))
    return reader, reader.peek(HEAD)[:HEAD]
