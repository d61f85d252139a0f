"""A result that another thread brings."""

from __future__ import annotations

import threading
from typing import Generic, TypeVar

Result = TypeVar("Result")


class Pending(Generic[Result]):
    """One thread waits in `result`, another one settles it: with a result or an exception, and the first counts."""

    def __init__(self) -> None:
        self._settled = threading.Event()
        self._lock = threading.Lock()
        self._error: BaseException | None = None
        self._result: Result

    @property
    def settled(self) -> bool:
        return self._settled.is_set()

    def settle(self, result: Result) -> bool:
        """False if it was settled before: the result is still the caller's then."""
        with self._lock:
            if self._settled.is_set():
                return False
            self._result = result
            self._settled.set()
            return True

    def fail(self, error: BaseException) -> bool:
        """False if it was settled before."""
        with self._lock:
            if self._settled.is_set():
                return False
            self._error = error
            self._settled.set()
            return True

    def result(self, timeout: float | None = None) -> Result:
        """Wait for it; raises the exception it failed with, or TimeoutError after `timeout` seconds (None: never)."""
        if not self._settled.wait(timeout):
            raise TimeoutError
        if self._error is not None:
            raise self._error
        return self._result
