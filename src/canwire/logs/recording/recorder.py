"""A running recording: writes the entries of a source to files, in a thread or when the lab's time passes."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING, Protocol

from canwire.errors import BadValue
from canwire.logs.batch import LogBatch, batch_of
from canwire.logs.entry import LogEntry, LogMark, MarkKind
from canwire.logs.recording.files import RecordingFiles
from canwire.logs.recording.triggers import Gate, RecordTriggers

if TYPE_CHECKING:
    import numpy

_TURN_S = 0.2


class RecordingSource(Protocol):
    """The source of a recording: `channels` are the names in the log; `address` is that of the line, not of its bus."""

    channels: list[str]
    address: str

    def take(self, timeout_s: float) -> numpy.ndarray:
        """Return received records of `log_dtype()`, waiting for the first; none if none arrived in time."""

    def lost(self) -> list[int]:
        """Return, for each channel, the number of frames and events lost so far because they were not read in time."""

    def marks(self) -> list[LogEntry]:
        """Return entries for the beginning of the log: bit rates, the clock."""

    def start(self, drain: Callable[[], None]) -> bool:
        """Arrange that `drain` is called for new entries; returns False if a thread must call it."""

    def close(self) -> None:
        """End the source."""


class Recorder:
    """A recording of lines in files until `close`; made by `record`, a context manager.

    Entries older than a second can be read from the files even if this process is killed. `close` raises the error
    that ended the recording: OSError for a full disk, HubLost.
    """

    def __init__(
        self,
        source: RecordingSource,
        files: RecordingFiles,
        closing: ExitStack,
        triggers: RecordTriggers | None = None,
    ) -> None:
        self._source = source
        self._files = files
        self._closing = closing
        self._channels = list(source.channels)
        self._ends_s: float | None = None
        self._gate = None if triggers is None else Gate(triggers, self._channels)
        self._lost = [0] * len(self._channels)
        self._latest_ns = 0
        self._error: Exception | None = None
        self._stop = threading.Event()
        self._over = threading.Event()
        self._closed = False
        self._begin_ns = time.time_ns()
        self._until_ns: int | None = None
        marks = source.marks()
        if marks:
            self._begin_ns = marks[0].timestamp_ns
            files.write(batch_of(marks, self._channels))
        self._thread: threading.Thread | None = None
        if not source.start(self._drain):
            self._thread = threading.Thread(target=self._run, name="canwire recorder", daemon=True)
            self._thread.start()

    @property
    def files(self) -> list[str]:
        """The files so far, the last one growing."""
        return list(self._files.files)

    @property
    def count(self) -> int:
        """The number of entries written so far."""
        return self._files.count

    @property
    def lost(self) -> int:
        """Frames and events that are missing in the log because they came faster than they were read."""
        return sum(self._lost)

    @property
    def left_out(self) -> dict[str, int]:
        """Data that the format cannot hold, with counts."""
        return self._files.left_out

    @property
    def error(self) -> Exception | None:
        """The error that ended the recording, or None."""
        return self._error

    @property
    def starts(self) -> int:
        """How often a trigger has started the recording."""
        return 0 if self._gate is None else self._gate.starts

    def end_after(self, span_s: float) -> None:
        """End `span_s` seconds after the beginning, by time stamps: later entries are not kept, and `wait` ends.

        Raises BadValue unless it is a number above 0.
        """
        if not isinstance(span_s, int | float) or not 0 < span_s < 1e9:
            raise BadValue(f"span_s {span_s!r}: a number of seconds above 0")
        self._until_ns = self._begin_ns + round(span_s * 1e9)

    def wait(self, timeout: float | None = None) -> bool:
        """Wait at most `timeout` seconds for the end of the recording (an error, a last stop); True if it ended."""
        return self._over.wait(timeout)

    def close(self) -> None:
        """Write the rest and finish the file; a second call does nothing. Raises the error of the recording."""
        if self._closed:
            return
        self._closed = True
        self._stop.set()
        try:
            if self._thread is not None:
                self._thread.join()
            with self._closing:
                if not self._over.is_set():
                    self._turn(0.0)
                self._source.close()
                if self._error is None:
                    self._files.close()
        finally:
            self._over.set()
        if self._error is not None:
            raise self._error

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self._closed else "over" if self._over.is_set() else "recording"
        return (
            f"<Recorder of {', '.join(self._channels)} to {self.files[-1]!r}: {self.count} entries, {state}>"
        )

    def _run(self) -> None:
        while not self._stop.is_set() and not self._over.is_set():
            self._turn(_TURN_S)

    def _drain(self) -> None:
        """Write new entries; called in the lab's time. Does nothing once the recording has ended or is closed."""
        if not self._over.is_set() and not self._closed:
            self._turn(0.0)

    def _turn(self, timeout_s: float) -> None:
        """Read the waiting records and write them; an error ends the recording and is kept for `close`."""
        try:
            records = self._wanted(self._source.take(timeout_s))
            if len(records):
                self._latest_ns = int(records["time_ns"][-1])
                self._write(records)
            self._tell_losses()
            self._files.tend()
            if self._gate is not None and self._has_ended(self._gate):
                self._over.set()
        except Exception as error:  # kept and raised again: close() tells it, wait() ends
            self._error = error
            self._over.set()

    def _wanted(self, records: numpy.ndarray) -> numpy.ndarray:
        """Return the records before the end of the recording."""
        if self._until_ns is None:
            return records
        late = records["time_ns"] > self._until_ns
        if late.any():
            self._over.set()
        return records[~late]

    def _write(self, records: numpy.ndarray) -> None:
        for piece in [records] if self._gate is None else self._gate.passed(records):
            if len(piece):
                self._files.write(LogBatch(piece, self._channels))

    def _has_ended(self, gate: Gate) -> bool:
        """Whether a stopped recording has ended: by time stamps, or by the clock if no more entries arrive."""
        if gate.ending_s is None:
            self._ends_s = None
        elif self._ends_s is None:
            self._ends_s = time.monotonic() + gate.ending_s
        return gate.over or (self._ends_s is not None and time.monotonic() >= self._ends_s)

    def _tell_losses(self) -> None:
        for number, lost in enumerate(self._source.lost()):
            if lost > self._lost[number]:
                mark = LogMark(MarkKind.LOST, self._latest_ns, count=lost - self._lost[number])
                entry = LogEntry(self._latest_ns, self._channels[number], mark)
                self._files.write(batch_of([entry], self._channels))
                self._lost[number] = lost
