"""A progress bar on stderr: only on a terminal, and only once it has lasted."""

from __future__ import annotations

import sys
import time

_WIDTH = 40
_PATIENCE_S = 1.0
_INTERVAL_S = 0.1


class Progress:
    """`show` it how far things are; a context manager that cleans its line up at the end."""

    def __init__(self, total: int, what: str) -> None:
        self._total = max(1, total)
        self._what = what
        self._terminal = sys.stderr.isatty()
        self._next_s = time.monotonic() + _PATIENCE_S
        self._shown = False

    def show(self, done: int) -> None:
        """`done` of `total`; draws ten times a second at most."""
        if not self._terminal or time.monotonic() < self._next_s:
            return
        self._next_s = time.monotonic() + _INTERVAL_S
        self._shown = True
        part = min(1.0, done / self._total)
        full = round(part * _WIDTH)
        bar = "#" * full + "." * (_WIDTH - full)
        print(f"\r{self._what} [{bar}] {part:4.0%}", end="", file=sys.stderr, flush=True)

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
