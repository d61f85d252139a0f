"""Records all rows of some lines in a file, including the marks that the trace shows."""

from __future__ import annotations

import tempfile
import threading
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from canwire import BadValue, InUse, LogWriter, create_log
from canwire.web.trace.saving import write_rows
from canwire.web.trace.store.history import CHUNK, History
from canwire.web.words import Trouble

if TYPE_CHECKING:
    from collections.abc import Collection

    from canwire.web.trace.taps import Taps


class Progress(NamedTuple):
    """The state of the recording. `rows` were written; `missed` rows were overwritten before they could be written.

    `trouble` is the error that ended it. `files` are the numbers of the existing recordings.
    """

    running: bool
    files: tuple[int, ...]
    rows: int
    missed: int
    trouble: str


class Recording:
    """The server's recording, one at a time; each has a separate file, which is deleted when the server ends."""

    def __init__(self, history: History, taps: Taps) -> None:
        self._history = history
        self._taps = taps
        self._lock = threading.Lock()
        self._grown = threading.Event()
        self._ends = threading.Event()
        self._thread: threading.Thread | None = None
        self._folder = tempfile.TemporaryDirectory(prefix="canwire-web-")
        self._progress = Progress(False, (), 0, 0, "")

    def path(self, number: int = 0) -> Path:
        """Return the file of that recording, 0: the last one; raises BadValue if it does not exist."""
        files = self._progress.files
        number = number or max(files, default=0)
        if number not in files:
            raise BadValue("nothing was recorded yet" if not files else f"there is no recording {number}")
        return Path(self._folder.name, f"trace-{number}.log")

    @property
    def progress(self) -> Progress:
        return self._progress

    def start(self, lines: Collection[str]) -> None:
        """Start a recording of all rows from now on, in a new file; raises InUse if a recording runs."""
        with self._lock:
            if self._thread is not None and self._thread.is_alive():
                raise InUse("a recording runs already; stop it first")
            self._ends.clear()
            self._taps.want(self, lines)
            self._taps.settle()  # what was heard before has its numbers
            files = self._progress.files
            self._progress = Progress(True, (*files, len(files) + 1), 0, 0, "")
            self._thread = threading.Thread(
                target=self._run, args=(list(lines), self._history.total), name="recording"
            )
            self._thread.start()

    def stop(self) -> None:
        """Stop the recording after writing all rows received before; a second call does nothing."""
        with self._lock:
            if self._thread is not None:
                self._taps.settle()
                self._ends.set()
                self._grown.set()
                self._thread.join()
                self._thread = None

    def close(self) -> None:
        """Stop, and remove the files."""
        self.stop()
        self._folder.cleanup()

    def _run(self, lines: list[str], cursor: int) -> None:
        trouble = ""
        self._history.listen(self._grown.set)
        try:
            with create_log(self.path(), format="candump") as log:
                self._write(log, lines, cursor)
        except OSError as error:  # the disk is full, perhaps
            trouble = Trouble.of(error)
        finally:
            self._history.unlisten(self._grown.set)
            self._taps.want(self, ())
            self._progress = self._progress._replace(running=False, trouble=trouble)

    def _write(self, log: LogWriter, lines: list[str], cursor: int) -> None:
        while True:
            self._grown.clear()
            ends = self._ends.is_set()  # after that: what sets it wakes this up as well
            while cursor < self._history.total:
                end = min(cursor + CHUNK, self._history.total)
                rows = self._history.read(cursor, end)
                missed, cursor = end - cursor - len(rows), end
                names = names_of(self._taps, lines)
                count = write_rows(log, rows, names, self._history.eras, errors=True) if names else 0
                now = self._progress
                self._progress = now._replace(rows=now.rows + count, missed=now.missed + missed)
            if ends:
                return
            self._grown.wait()


def names_of(taps: Taps, lines: Collection[str]) -> dict[int, str]:
    """Return the names of the lines' channels in logs, by the lines' numbers in rows."""
    return {one.number: one.bus or one.address for one in taps.watched(lines) if one.number >= 0}
