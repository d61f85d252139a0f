"""The time that a run may take: it is ended in the thread that plays it, or else its process is."""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import os
import threading
from collections.abc import Iterator

from canwire.errors import BadValue

GRACE_S = 1.0  # what a run's own `finally` may take before its process is ended
MOST_S = 1e6


class TooLong(BaseException):
    """Raised in a run that has taken longer than it may. No Exception: scripts catch those."""


def limit_of(seconds: float | None) -> float | None:
    """Seconds a run may take, 0.001 to 1,000,000, None: any; raises BadValue."""
    if seconds is not None and not 0.001 <= seconds <= MOST_S:
        raise BadValue(f"time limit {seconds}: 0.001 to 1,000,000 seconds for each run")
    return seconds


@contextlib.contextmanager
def at_most(limit_s: float | None) -> Iterator[None]:
    """What runs in this thread is ended by TooLong after so many seconds (None: never).

    That comes between two steps of Python: compiled code that never returns to it is not ended, which is what
    `process_at_most` is for.
    """
    if limit_s is None:
        yield
        return
    watch = _Watch(limit_s)
    try:
        yield
    finally:
        watch.end()


@contextlib.contextmanager
def process_at_most(limit_s: float | None, grace_s: float = GRACE_S) -> Iterator[None]:
    """This process ends if what runs in it is not over after so many seconds and `grace_s` (None: never)."""
    if limit_s is None:
        yield
        return
    with open(os.devnull, "w") as nowhere:
        faulthandler.dump_traceback_later(limit_s + grace_s, exit=True, file=nowhere)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()


class _Watch:
    """Over the thread that makes it, until `end`."""

    def __init__(self, limit_s: float) -> None:
        self._lock = threading.Lock()
        self._over = self._late = False
        self._thread = ctypes.c_ulong(threading.get_ident())
        self._timer = threading.Timer(limit_s, self._interrupt)
        self._timer.daemon = True
        self._timer.start()

    def end(self) -> None:
        """Nothing is raised from now on; what is to be raised already is raised here.

        It must not be taken back: CPython 3.11 then goes on looking for it at each step of every thread, for ever,
        and under a profiler goes no further.
        """
        self._timer.cancel()
        with self._lock:
            self._over = True
        if self._late:
            _step()
            raise TooLong

    def _interrupt(self) -> None:
        with self._lock:
            if not self._over:
                self._late = True
                ctypes.pythonapi.PyThreadState_SetAsyncExc(self._thread, ctypes.py_object(TooLong))


def _step() -> None:
    """Where the interpreter looks for what it is to raise: at the call."""
