"""How far a long verb is, on stderr: a bar on a terminal, elsewhere a line every ten seconds for verbs that want it."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_WIDTH = 40
_PATIENCE_S = 1.0
_INTERVAL_S = 0.1
_LINES_S = 10.0


class Progress:
    """Shows the progress that `show` is given; a context manager that removes its line at the end.

    Without a `total` it shows the number alone. Where stderr is no terminal it shows `lines` or nothing; a `quiet` one
    shows nothing anywhere.
    """

    def __init__(
        self, total: int | None, what: str, *, unit: str = "", lines: bool = False, quiet: bool = False
    ) -> None:
        self._total = total
        self._what = what
        self._unit = unit
        self._terminal = sys.stderr.isatty()
        self._quiet = quiet or not (lines or self._terminal)
        self._next_s = time.monotonic() + (_PATIENCE_S if self._terminal else _LINES_S)
        self._shown = False

    def show(self, done: int, more: str = "") -> None:
        """Show `done` of the total and `more`; on a terminal at most ten times a second, else every ten seconds."""
        if self._quiet or (now_s := time.monotonic()) < self._next_s:
            return
        if not self._terminal:
            self._next_s = now_s + _LINES_S
            print(f"canwire: {self._what}: {self._text(done)}{more}", file=sys.stderr, flush=True)
            return
        self._next_s = now_s + _INTERVAL_S
        self._shown = True
        print(f"\r{self._what} {self._bar(done)}{more}\x1b[K", end="", file=sys.stderr, flush=True)

    def _text(self, done: int) -> str:
        if not self._total:
            return f"{done}{self._unit}"
        return f"{done} of {self._total}{self._unit}"

    def _bar(self, done: int) -> str:
        if not self._total:
            return self._text(done)
        part = min(1.0, done / self._total)
        full = round(part * _WIDTH)
        return f"[{'#' * full + '.' * (_WIDTH - full)}] {part:4.0%}"

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def end(self) -> None:
        """Remove the line from the terminal, so that other output can follow."""
        if self._shown:
            self._shown = False
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


@contextmanager
def watched(progress: Progress, done: Callable[[], int]) -> Iterator[None]:
    """A context in which a thread calls `done` regularly and shows the progress, for a long call."""
    ended = threading.Event()

    def look() -> None:
        while not ended.wait(_INTERVAL_S):
            progress.show(done())

    thread = threading.Thread(target=look, daemon=True)
    thread.start()
    try:
        with progress:
            yield
    finally:
        ended.set()
        thread.join()
