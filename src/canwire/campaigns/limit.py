"""The time limit of a run: an exception ends the run in its thread; if that fails, its process is ended."""

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
    """Raised in a run that exceeds its time limit. It is not an Exception, because scripts catch those."""


def limit_of(seconds: float | None) -> float | None:
    """The time limit of a run in s, 0.001 to 1,000,000 (None: no limit); raises BadValue."""
    if seconds is not None and not 0.001 <= seconds <= MOST_S:
        raise BadValue(f"time limit {seconds}: 0.001 to 1,000,000 seconds for each run")
    return seconds


@contextlib.contextmanager
def at_most(limit_s: float | None) -> Iterator[None]:
    """Raise TooLong in this thread after `limit_s` seconds (None: never).

    The exception is raised between two bytecodes: compiled code that does not return to Python is not ended. For such
    code use `process_at_most`.
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
    """End this process if the code inside is not over after `limit_s` plus `grace_s` seconds (None: never)."""
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
    """Watches the thread that makes it, until `end`."""

    def __init__(self, limit_s: float) -> None:
        self._lock = threading.Lock()
        self._over = self._late = False
        self._thread = ctypes.c_ulong(threading.get_ident())
        self._timer = threading.Timer(limit_s, self._interrupt)
        self._timer.daemon = True
        self._timer.start()

    def end(self) -> None:
        """Stop watching; an exception that is already pending is raised here.

        A pending exception must not be cancelled: CPython 3.11 then checks for it at each bytecode of every thread
        without end, and hangs under a profiler.
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
    """A call, at which the interpreter checks for a pending exception."""
