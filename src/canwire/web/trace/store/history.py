"""Every row of a trace, numbered and in the order of time: the newest in memory, older ones in a file of the server.

Numbers never change, so that every viewer, saved log and recording has the same rows. The oldest rows are removed, in
whole chunks, once there are more than `most`.
"""

from __future__ import annotations

import os
import tempfile
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

import numpy

from canwire.web.trace.store.identifiers import Identifiers
from canwire.web.trace.store.rows import LATE, ROW_BYTES, row_dtype
from canwire.web.words import Trouble

if TYPE_CHECKING:
    from numpy.typing import NDArray

CHUNK = 1 << 14  # rows that are written, read and dropped together
MOST = 16_000_000  # rows, 1.4 GB
_DISK = "/var/tmp"  # for a file without a name; /tmp is memory on many machines


class Era(NamedTuple):
    """The time of one hub connection: in rows from number `first` on, times count from `epoch_ns` after 1970 (0:
    unknown)."""

    first: int
    epoch_ns: int


class History:
    """One thread writes, any thread may read. `total` counts all rows so far; rows from number `first` on are kept.

    `late` counts rows that arrived after later ones; `trouble` is the reason why rows are kept only in memory, or "".
    """

    def __init__(self, memory: int = 8 * CHUNK, most: int = MOST) -> None:
        self._memory = max(memory, 2 * CHUNK) // CHUNK * CHUNK
        self._slots = max(most // CHUNK, 2)
        self._ring = numpy.zeros(self._memory, row_dtype())
        self._file: BinaryIO | None = None
        self._lock = threading.Lock()
        self._listeners: list[Callable[[], None]] = []
        self.total = self.first = self.late = 0
        self.trouble = ""
        self.eras: list[Era] = [Era(0, 0)]
        self.identifiers = Identifiers()

    def listen(self, grown: Callable[[], None]) -> None:
        """Call `grown`, in the writer's thread, after every write."""
        with self._lock:
            self._listeners.append(grown)

    def unlisten(self, grown: Callable[[], None]) -> None:
        with self._lock:
            self._listeners.remove(grown)

    def begin_era(self, epoch_ns: int) -> None:
        """Count time from here, beginning with the next row."""
        era = Era(self.total, epoch_ns)
        with self._lock:
            self.eras = [*(one for one in self.eras if one.first < era.first), era]
        self.identifiers.restart()

    def append(self, rows: numpy.ndarray) -> None:
        """Append rows in the order of time, and number them."""
        for at in range(0, len(rows), CHUNK):
            self._append(rows[at : at + CHUNK])
        self.identifiers.add(rows)
        with self._lock:
            listeners = list(self._listeners)
        for grown in listeners:
            grown()

    def read(self, begin: int, end: int) -> numpy.ndarray:
        """Return the rows with numbers from `begin` up to `end`; removed or future rows are left out."""
        with self._lock:
            begin, end = max(begin, self.first), min(end, self.total)
            kept = max(0, self.total - self._memory)
            if begin >= kept:
                return self._kept(begin, end)
        older = self._stored(begin, min(end, kept))
        if end <= kept:
            return older
        newer = self.read(kept, end)
        if len(newer) < end - kept:  # some of them have gone to the file meanwhile
            return self.read(begin, end)
        return numpy.concatenate((older, newer))

    def pick(self, numbers: NDArray[numpy.int64]) -> numpy.ndarray:
        """Return the rows with these ascending numbers; removed rows are left out."""
        found = []
        for part in numpy.split(numbers, numpy.flatnonzero(numpy.diff(numbers // CHUNK)) + 1):
            if len(part):
                begin, end = int(part[0]), int(part[-1]) + 1
                rows = self.read(begin, end)
                missing = end - begin - len(rows)
                places = part - begin - missing
                found.append(rows[places[places >= 0]])
        return _joined(found)

    def blocks(self, begin: int, end: int) -> Iterator[numpy.ndarray]:
        """Yield the rows between two numbers, some ten thousand at a time."""
        begin = max(begin, self.first)
        while begin < end:
            stop = min((begin // CHUNK + 4) * CHUNK, end)
            yield self.read(begin, stop)
            begin = stop

    def close(self) -> None:
        """Close and remove the file; a second call does nothing."""
        with self._lock:
            file, self._file = self._file, None
            if file is not None:
                self.first = max(self.first, self.total - self._memory)
                file.close()

    def _append(self, rows: numpy.ndarray) -> None:
        with self._lock:
            begin, end = self.total, self.total + len(rows)
            rows["number"] = numpy.arange(begin, end) & 0xFFFFFFFF
            self.late += int((rows["flags"] & LATE != 0).sum())
            for chunk in range((begin + CHUNK - 1) // CHUNK, (end + CHUNK - 1) // CHUNK):
                self._spill(chunk - self._memory // CHUNK)  # its place in memory is needed now
            at = begin % self._memory
            first = min(len(rows), self._memory - at)
            self._ring[at : at + first] = rows[:first]
            self._ring[: len(rows) - first] = rows[first:]
            self.total = end
            self.first = max(self.first, (end - 1) // CHUNK * CHUNK + CHUNK - self._slots * CHUNK)
            if self.trouble:
                self.first = max(self.first, (end - 1) // CHUNK * CHUNK + CHUNK - self._memory)

    def _spill(self, chunk: int) -> None:
        """Write a chunk of the memory to the file. A full disk ends that, and is reported."""
        if chunk < 0 or self.trouble:
            return
        at = chunk * CHUNK % self._memory
        try:
            if self._file is None:
                folder = _DISK if os.access(_DISK, os.W_OK) else None
                self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 - closed by close()
            octets = self._ring[at : at + CHUNK].tobytes()
            if os.pwrite(self._file.fileno(), octets, chunk % self._slots * len(octets)) < len(octets):
                raise OSError("the disk is full")
        except OSError as error:
            self.trouble = Trouble.of(error)

    def _kept(self, begin: int, end: int) -> numpy.ndarray:
        """Return a copy of rows in memory."""
        if end <= begin:
            return numpy.zeros(0, row_dtype())
        at = begin % self._memory
        stop = at + end - begin
        if stop <= self._memory:
            return self._ring[at:stop].copy()
        return numpy.concatenate((self._ring[at:], self._ring[: stop - self._memory]))

    def _stored(self, begin: int, end: int) -> numpy.ndarray:
        """Rows from the file, without those that were overwritten while they were read."""
        parts = []
        at = begin
        while at < end:
            chunk = at // CHUNK
            stop = min((chunk - chunk % self._slots + self._slots) * CHUNK, end)  # the file goes round there
            place = (chunk % self._slots * CHUNK + at % CHUNK) * ROW_BYTES
            with self._lock:
                octets = b"" if self._file is None else os.pread(
                    self._file.fileno(), (stop - at) * ROW_BYTES, place)  # fmt: skip
            parts.append(numpy.frombuffer(octets, row_dtype(), len(octets) // ROW_BYTES))
            at = stop
        rows = _joined(parts)
        return rows[max(0, self.first - begin) :]


def _joined(parts: list[numpy.ndarray]) -> numpy.ndarray:
    """Concatenate the parts; a single part is not copied."""
    if len(parts) == 1:
        return parts[0]
    return numpy.concatenate(parts) if parts else numpy.zeros(0, row_dtype())
