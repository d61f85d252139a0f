"""Everything from some lines into a file, for as long as wanted: it loses no row while a page may skip some."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from canwire import BadValue, HubLost, InUse
from canwire.web.trace.history import GAP, History
from canwire.web.trace.saving import format_rows

if TYPE_CHECKING:
    from collections.abc import Collection

    from canwire.web.trace.taps import Taps

_AT_ONCE = 4096


class Progress(NamedTuple):
    """`rows` written, `missed` ones that were gone before they could be; `trouble` is why it ended by itself."""

    running: bool
    there: bool
    rows: int
    missed: int
    trouble: str


class Recording:
    """One for the whole server. `epoch_ns()` is what to add to the hub's time now; it raises HubLost without one."""

    def __init__(self, history: History, taps: Taps, epoch_ns: Callable[[], int]) -> None:
        self._history = history
        self._taps = taps
        self._epoch_ns = epoch_ns
        self._lock = threading.Lock()
        self._grown = threading.Event()
        self._ends = threading.Event()
        self._thread: threading.Thread | None = None
        self._folder = tempfile.TemporaryDirectory(prefix="canwire-web-")
        self._progress = Progress(False, False, 0, 0, "")

    @property
    def path(self) -> Path:
        """The file, of the recording that runs or ran last; raises BadValue before there was one."""
        if not self._progress.there:
            raise BadValue("nothing was recorded yet")
        return Path(self._folder.name, "trace.log")

    @property
    def progress(self) -> Progress:
        return self._progress

    def start(self, lines: Collection[str]) -> None:
        """Begin with what comes from now on, in place of the recording before; raises InUse while one runs, HubLost."""
        with self._lock:
            if self._thread is not None and self._thread.is_alive():
                raise InUse("a recording runs already; stop it first")
            epoch_ns = self._epoch_ns()
            self._ends.clear()
            self._taps.want(self, lines)
            self._progress = Progress(True, True, 0, 0, "")
            self._thread = threading.Thread(target=self._run, args=(list(lines), epoch_ns), name="recording")
            self._thread.start()

    def stop(self) -> None:
        """What came before is written; a second time does nothing."""
        with self._lock:
            if self._thread is not None:
                self._ends.set()
                self._grown.set()
                self._thread.join()
                self._thread = None

    def close(self) -> None:
        """Stop, and remove the file."""
        self.stop()
        self._folder.cleanup()

    def _run(self, lines: list[str], epoch_ns: int) -> None:
        trouble = ""
        self._history.listen(self._grown.set)
        try:
            with self.path.open("w", encoding="utf-8") as log:
                self._write(log.write, lines, epoch_ns)
        except OSError as error:  # the disk is full, perhaps
            trouble = str(error)
        finally:
            self._history.unlisten(self._grown.set)
            self._taps.want(self, ())
            self._progress = self._progress._replace(running=False, trouble=trouble)

    def _write(self, write: Callable[[str], object], lines: list[str], epoch_ns: int) -> None:
        cursor = self._history.total
        while True:
            self._grown.clear()
            ends = self._ends.is_set()  # after that: what sets it wakes this up as well
            while cursor < self._history.total:
                names = {
                    one.number: one.bus or one.address for one in self._taps.watched() if one.address in lines
                }
                rows, missed, cursor = self._history.since(cursor, _AT_ONCE, [*names, 0xFFFF])
                if (rows["record"]["info"] == GAP).any():
                    with suppress(HubLost):  # gone again: the next gap's end will tell
                        epoch_ns = self._epoch_ns()
                texts = format_rows(rows, names, epoch_ns, errors=True)
                write("".join(f"{text}\n" for text in texts))
                now = self._progress
                self._progress = now._replace(rows=now.rows + len(texts), missed=now.missed + missed)
            if ends:
                return
            self._grown.wait()
