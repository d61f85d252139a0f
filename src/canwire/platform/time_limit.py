"""A limit of time for somebody else's parser, which looks at no clock itself."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

# as they are while this is loaded: in a program that keeps a hub's time, threading's own wait in that time
_thread, _lock = threading.Thread, threading.Lock
_raise_in = ctypes.pythonapi.PyThreadState_SetAsyncExc


class _OverError(BaseException):
    """Raised in the thread that parses, between two of its bytecodes; no `except Exception` there catches it."""


@contextmanager
def time_limit(seconds: float, error: Callable[[], Exception]) -> Iterator[None]:
    """Raises this error where what is done inside takes longer; within one call of C's it waits for that to end.

    A thread watches the clock; another Python than CPython has no such limit.
    """
    watch = _Watch(threading.get_ident(), seconds)
    try:
        with watch:
            yield
    except _OverError:
        raise error() from None


class _Watch:
    def __init__(self, parser: int, seconds: float) -> None:
        self._parser = ctypes.c_ulong(parser)
        self._seconds = seconds
        self._over = _lock()  # free once it is over, one way or the other
        self._turn = _lock()
        self._ended = False

    def __enter__(self) -> None:
        self._over.acquire()
        _thread(target=self._look, name="canwire-time-limit", daemon=True).start()

    def __exit__(self, *_: object) -> None:
        with self._turn:
            self._ended = True
            _raise_in(self._parser, None)  # what was raised in the last moment is not meant any more
        self._over.release()

    def _look(self) -> None:
        if self._over.acquire(timeout=self._seconds):
            return
        with self._turn:
            if not self._ended:
                _raise_in(self._parser, ctypes.py_object(_OverError))
