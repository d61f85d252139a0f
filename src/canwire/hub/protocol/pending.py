"""A result that another thread sets."""

from __future__ import annotations

from _thread import allocate_lock  # not threading's, which may wait in a hub's time (canwire.in_time)
from collections.abc import Callable
from typing import Generic, TypeVar

Result = TypeVar("Result")
_LOOK_S = 1.0  # a signal that comes in the moment before the wait begins is heard then


class Pending(Generic[Result]):
    """One thread waits in `result`; another one settles it with a result or an exception. Only the first one counts.

    The wait uses a bare lock: a signal that raises in the middle of a threading.Event's wait may leave the Event
    locked, and then the thread that settles it would never return.
    """

    def __init__(self) -> None:
        self._gate = allocate_lock()  # locked until it is settled
        self._gate.acquire()
        self._done = False
        self._lock = allocate_lock()
        self._error: BaseException | None = None
        self._result: Result
        self._told: Callable[[], object] | None = None

    @property
    def settled(self) -> bool:
        return self._done

    def settle(self, result: Result) -> bool:
        """Set the result. False if it was settled before; the caller then still owns the result."""
        with self._lock:
            if self._done:
                return False
            self._result = result
            self._done = True
        self._open()
        return True

    def fail(self, error: BaseException) -> bool:
        """Set an exception. False if it was settled before."""
        with self._lock:
            if self._done:
                return False
            self._error = error
            self._done = True
        self._open()
        return True

    def when_settled(self, told: Callable[[], object]) -> None:
        """Call `told` once: in the thread that settles it, or now if it is settled; `result` does not wait then."""
        with self._lock:
            if not self._done:
                self._told = told
                return
        told()

    def result(self, timeout: float | None = None) -> Result:
        """Wait for the result; raises the exception set, or TimeoutError after `timeout` seconds (None: never)."""
        if not self._done:
            while not self._gate.acquire(timeout=_LOOK_S if timeout is None else timeout):
                if timeout is not None:
                    raise TimeoutError
            self._gate.release()
        if self._error is not None:
            raise self._error
        return self._result

    def _open(self) -> None:
        self._gate.release()
        if self._told is not None:
            self._told()
