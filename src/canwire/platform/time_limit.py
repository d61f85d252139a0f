"""A time limit for third-party parsers, which do not limit their time themselves."""

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
    """Raise this error if the code inside takes longer. A call into C code is interrupted only after it returns.

    A thread watches the clock. The limit works on CPython only.
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
