"""A lock that a signal never leaves taken.

Python handles a signal before the first step of a function. Where `__exit__` is a function of Python, Ctrl-C can come
there, and the lock is then kept by the exception's traceback. These ones are compiled, so it comes before or after.
(contextlib's `__exit__` is Python's.)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Hold:
    """A context that holds `lock`; `entered` is called first, `leaving` last, both with the lock.

    It is in `asked` for as long as it waits for the lock.
    """

    def __init__(
        self,
        lock: Any,
        asked: set[Hold],
        *,
        entered: Callable[[], object] | None = None,
        leaving: Callable[[], object] | None = None,
    ) -> None:
        self._lock = lock
        self._asked = asked
        self._entered = entered
        self._leaving = leaving

    def __enter__(self) -> None:
        self._asked.add(self)
        try:
            self._lock.acquire()
        finally:
            self._asked.discard(self)
        if self._entered is not None:
            try:
                self._entered()
            except BaseException:
                self._lock.release()
                raise

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        try:
            if self._leaving is not None:
                self._leaving()
        finally:
            self._lock.release()
