"""A time limit for code that does not check a clock: the parser of another library, a run of a campaign."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

# as they are while this is loaded: in a program that keeps a hub's time, threading's own wait in that time
_thread, _lock = threading.Thread, threading.Lock


class _OverError(BaseException):
    """Raised in the thread that parses, between two of its bytecodes; no `except Exception` there catches it."""


@contextmanager
def time_limit(seconds: float, error: Callable[[], Exception]) -> Iterator[None]:
    """Raises this error if the code inside takes longer; a single call of C is not interrupted.

    Another thread watches the clock. Only CPython has such a limit.
    """
    try:
        with interrupted_after(seconds, _OverError):
            yield
    except _OverError:
        raise error() from None


@contextmanager
def interrupted_after(seconds: float, error: type[BaseException]) -> Iterator[None]:
    """Raises `error` in this thread between two steps of Python, if the code inside takes longer than this."""
    watch = _Watch(seconds, error)
    try:
        yield
    finally:
        watch.end()


class _Watch:
    """Watches the time of the thread that makes it, until `end`."""

    def __init__(self, seconds: float, error: type[BaseException]) -> None:
        self._error = error
        self._watched = ctypes.c_ulong(threading.get_ident())
        self._seconds = seconds
        self._ended = _lock()  # free once the watch has ended
        self._turn = _lock()
        self._over = self._late = False
        self._ended.acquire()
        _thread(target=self._watch, name="canwire-time-limit", daemon=True).start()

    def end(self) -> None:
        """Nothing is raised from now on; an exception that is on its way is raised here.

        A pending exception must not be withdrawn: CPython 3.11 would then check for it at each step of every thread
        without end, and make no progress under a profiler or a tracer.
        """
        with self._turn:
            self._over = True
        self._ended.release()
        if self._late:
            _step()
            raise self._error

    def _watch(self) -> None:
        if self._ended.acquire(timeout=self._seconds):
            return
        with self._turn:
            if not self._over:
                self._late = True
                ctypes.pythonapi.PyThreadState_SetAsyncExc(self._watched, ctypes.py_object(self._error))


def _step() -> None:
    """Where the interpreter checks for an exception that it has to raise: at the call."""
