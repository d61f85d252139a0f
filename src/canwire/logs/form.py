"""The base class of the formats' writers, which turns records into bytes of a file."""

from __future__ import annotations

import os
import stat
from collections import Counter
from typing import TYPE_CHECKING, BinaryIO, ClassVar

from canwire.forks import lead_nowhere
from canwire.logs.entry import LogKind

if TYPE_CHECKING:
    import numpy

_AT_ONCE = 1 << 20  # bytes


class FormWriter:
    """Writes records into one file, in one format; LogWriter passes the records and reports errors.

    The channel numbers of records index `channels`; `dated`, `start_ns` and `clock` are as in `create_log`. `count` is
    the number of entries in the file; `left_out` counts the data that the format cannot hold.
    """

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)
    opens: ClassVar[bool] = True
    """The file is opened by `create_log`; else by a library, by its name."""
    needs_end: ClassVar[bool] = False
    """Readable only after `end`: the format has its index there. `record` keeps a journal beside such files."""

    def __init__(
        self, path: str, file: BinaryIO | None, *, dated: bool, start_ns: int | None, clock: str
    ) -> None:
        self.path = path
        self.file = file
        self.dated = dated
        self.start_ns = start_ns
        self.clock = clock
        self.count = 0
        self.left_out: Counter[str] = Counter()
        self.channels: list[str] = []
        self._waiting: list[tuple[bytes, int]] = []
        self._bytes = 0

    def begin(self) -> None:
        """Write the beginning of the file."""

    def put(self, records: numpy.ndarray) -> None:
        """Write records of `log_dtype()`, all of kinds that the format `holds`; their channels
        index `self.channels`."""
        raise NotImplementedError

    def sync(self) -> None:
        """Pass all bytes to the operating system."""
        if self.file is not None:
            self.drain()
            self.file.flush()

    def grown(self) -> int:
        """Return the size of the growing file in bytes."""
        return os.path.getsize(self.path) if os.path.exists(self.path) else 0

    def turn(self) -> bool:
        """Begin the next file of a log that is a folder of files; returns False for a log that is one file."""
        return False

    def end(self) -> None:
        """Write the end of the file."""
        self.sync()

    def give_up(self) -> None:
        """Release the resources of `begin` other than the file, which is then removed without further writing."""

    def leave_to_parent(self) -> None:
        """In a forked process: write nothing more into the parent's file."""
        if self.file is not None and self.path != "-":
            lead_nowhere(self.file)

    def leave_out(self, what: str, count: int) -> None:
        """Count data that the file cannot hold: "LIN frames", "nanoseconds of time stamps"."""
        self.left_out[what] += count

    def out(self, block: bytes, entries: int = 0) -> None:
        """Append bytes with this number of whole entries; they are written later, completely or not at all."""
        self._waiting.append((block, entries))
        self._bytes += len(block)
        if self._bytes >= _AT_ONCE:
            self.drain()

    def drain(self) -> None:
        """Write what `out` has collected. On a full disk the file ends after the last block that fits."""
        waiting, self._waiting, self._bytes = self._waiting, [], 0
        assert self.file is not None
        whole = self.file.tell() if self.file.seekable() else None
        try:
            for block, entries in waiting:
                write_all(self.file, block)
                self.count += entries
                whole = None if whole is None else whole + len(block)
        except OSError:
            if whole is not None and stat.S_ISREG(os.fstat(self.file.fileno()).st_mode):  # no device
                self.file.truncate(whole)
                self.file.seek(whole)
            raise


def write_all(file: BinaryIO, block: bytes) -> None:
    """Write the whole block: a raw file may write only a part of it in each call."""
    left = memoryview(block)
    while left:
        left = left[file.write(left) :]
