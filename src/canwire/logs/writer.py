"""Writes logs: `create_log`. Data that a format cannot hold are left out and counted."""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, BinaryIO, cast

from canwire.errors import CanwireError, Closed
from canwire.forks import hear_of_forks
from canwire.logs.batch import LogBatch, batch_of, renumbered
from canwire.logs.beside import Beside
from canwire.logs.entry import LogEntry, LogKind
from canwire.logs.form import FormWriter
from canwire.logs.formats import format_to_write, load_format
from canwire.logs.packing import Packing, packing_of, refuse_packed, unpacked_name
from canwire.values.checks import instance
from canwire.values.mistakes.calls import answers_wrong_calls

_KINDS = {
    LogKind.CAN_FRAME: "CAN frames",
    LogKind.CAN_EVENT: "error frames and events",
    LogKind.LIN_FRAME: "LIN frames",
    LogKind.LIN_EVENT: "LIN events",
    LogKind.MARK: "marks (lost counts, gaps, bit rates)",
}
_FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)


class LogWriter:
    """A log file that grows, made by `create_log`; a context manager.

    `write` accepts entries, `write_batch` numpy records, which is faster. After `flush` all entries are in the file,
    and `open_log` can read them, unless the format `needs_end` or the log is to be `whole`.
    """

    def __init__(
        self, path: str, format: str, form: FormWriter, beside: Beside | None = None, whole: bool = False
    ) -> None:
        self._path = path
        self._format = format
        self._form = form
        self._beside = beside
        self._whole = whole and beside is not None
        self._closed = False
        self._failed = False
        self._left = False
        hear_of_forks(self)
        try:
            self._telling(form.begin)
        except BaseException:
            if beside is not None:
                with suppress(OSError):  # Windows removes no file that is open
                    self._close_file()
                beside.give_up()
            raise

    @property
    def path(self) -> str:
        return self._path

    @property
    def format(self) -> str:
        """The name of its format: "candump", "blf"."""
        return self._format

    @property
    def count(self) -> int:
        """The number of entries in the file; more may wait for `flush`."""
        return self._form.count

    @property
    def channels(self) -> list[str]:
        """Names of the channels so far."""
        return list(self._form.channels)

    @property
    def needs_end(self) -> bool:
        """Whether the file can be read only after `close`, because its format has an index at the end."""
        return self._form.needs_end

    @property
    def size(self) -> int:
        """Size of the growing file in bytes; for a trace, the size of its unpacked records."""
        return self._form.grown()

    @property
    def left_out(self) -> dict[str, int]:
        """Data that the format cannot hold, with counts: {"LIN frames": 3}."""
        return dict(self._form.left_out)

    def write(self, entry: LogEntry) -> None:
        """Write one entry; raises BadValue for another object, OSError for a full disk."""
        instance("entry", entry, LogEntry)
        self.write_many((entry,))

    def write_many(self, entries: Iterable[LogEntry]) -> None:
        """Write several entries."""
        self.write_batch(batch_of(entries, self._form.channels))

    def write_batch(self, batch: LogBatch) -> None:
        """Write many entries. Raises OSError for a full disk; its message contains the number of
        entries in the file."""
        self._check_open()
        form = self._form
        records = renumbered(batch, form.channels)
        kinds = records["kind"]
        for kind in LogKind:
            if kind not in form.holds and (missing := int((kinds == kind).sum())):
                form.leave_out(_KINDS[kind], missing)
                records = records[records["kind"] != kind]
        if len(records):
            self._telling(lambda: form.put(records))

    def flush(self) -> None:
        """Pass all entries to the operating system, so that they survive this process."""
        if not self._closed:
            self._telling(self._form.sync)

    def rotate(self) -> bool:
        """Begin the next file of a trace; False for a log that is one file. Raises like `write_batch`."""
        self._check_open()
        turned: list[bool] = []
        self._telling(lambda: turned.append(self._form.turn()))
        return turned[0]

    def close(self) -> None:
        """Finish the file; a second call does nothing. A log that is to be `whole` is removed after an error."""
        if self._closed:
            return
        self._closed = True
        if self._whole and self._failed:
            self._give_up()
            return
        try:
            self._telling(self._finish)
        except BaseException:
            self._give_up()
            raise

    def __enter__(self) -> LogWriter:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        self._failed = self._failed or kind is not None
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self._closed else "open"
        return f"<LogWriter {self.path!r}, {self.format}, {self.count} entries, {state}>"

    def leave_to_parent(self) -> None:
        """In a forked process: write nothing more; the file belongs to the parent."""
        if not self._closed:
            self._closed = self._left = True
            self._form.leave_to_parent()

    def _check_open(self) -> None:
        if self._left:
            raise CanwireError(
                f"log {self.path} belongs to the process that was forked; create another in this one"
            )
        if self._closed:
            raise Closed(f"log {self.path}")

    def _finish(self) -> None:
        self._form.end()
        self._close_file()
        if self._beside is not None:
            self._beside.take_place()

    def _give_up(self) -> None:
        """Close the open files, and remove a temporary file that is not complete."""
        try:
            self._form.give_up()
            with suppress(OSError):  # a packed file has an end to write, and may not have the room
                self._close_file()
        finally:
            if self._beside is not None:
                self._beside.give_up()

    def _close_file(self) -> None:
        if self._form.file is not None and self.path != "-":
            self._form.file.close()

    def _telling(self, work: Callable[[], None]) -> None:
        try:
            work()
        except OSError as error:
            self._failed = True
            if error.filename == self._form.path:
                error.filename = self.path
            if error.errno not in _FULL or error.filename is not None:
                raise
            kept = f"the file ends whole, with its first {self.count} entries"
            told = f"{os.strerror(error.errno)}; {'nothing of it is kept' if self._whole else kept}"
            raise OSError(error.errno, told, self.path) from error
        except BaseException:
            self._failed = True
            raise


@answers_wrong_calls
def create_log(
    path: str | os.PathLike[str],
    *,
    format: str | None = None,
    dated: bool = True,
    start_ns: int | None = None,
    clock: str = "",
    whole: bool = False,
) -> LogWriter:
    """Create a log file, overwriting an old one; the suffix or `format` gives its format. "-" is standard output.

    A file with the suffix .gz or .zst is packed; the suffix before it gives the format ("drive.log.gz").
    A name that ends with a slash or ".trace", or that of a folder, means a trace; its folder must be new or empty.

    `dated`: time stamps count from 1970, else from an unknown zero. `start_ns`: the start in nanoseconds since 1970, if
    known. `clock`: the name of the clock. `whole`: write a temporary file, which is renamed to `path` by `close`; after
    an earlier error, of the writer or in its `with`, the old file is unchanged (this does not apply to traces and
    standard output). Formats that `needs_end` are written in this way, too.
    Raises BadValue for an unknown format, ExtraMissing for a missing library, OSError if the file cannot be opened;
    then an existing file is unchanged.

    >>> with create_log("out.log") as log:  # doctest: +SKIP
    ...     log.write(LogEntry(1_000_000, "can0", Frame(0x123), "R"))
    """
    name = os.fspath(path)
    row = format_to_write(unpacked_name(name), format)
    if packed := packing_of(name):
        refuse_packed(name, row.name)
    writer: type[FormWriter] = load_format(row).Writer
    one_file = name != "-" and row.name != "trace"
    beside = Beside(name) if one_file and (whole or writer.needs_end) else None
    made = name if beside is None else beside.made
    facts: dict[str, Any] = {"dated": dated, "start_ns": start_ns, "clock": clock}
    if not writer.opens or name == "-":
        file = sys.stdout.buffer if writer.opens else None
        return LogWriter(name, row.name, writer(made, file, **facts), beside, whole)
    with _opened(name, made) as raw:
        file = cast(BinaryIO, Packing(name, raw)) if packed else raw
        return LogWriter(name, row.name, writer(made, file, **facts), beside, whole)


@contextmanager
def _opened(name: str, path: str) -> Iterator[BinaryIO]:
    """Open the file, which is emptied only after the log has begun; a new file is removed if the log cannot begin."""
    new = not os.path.exists(path)
    try:
        file = open(path, "wb", buffering=0, opener=_kept)  # noqa: SIM115
    except OSError as error:
        error.filename = name
        raise
    try:
        yield cast(BinaryIO, file)
        if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            file.truncate(file.tell())
    except BaseException:
        file.close()
        if new and os.path.exists(path):
            os.remove(path)
        raise


def _kept(path: str, flags: int) -> int:
    """Open the file without emptying it."""
    return os.open(path, flags & ~os.O_TRUNC, 0o666)
