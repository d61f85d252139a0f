"""Locks that wait in the hub's time; for threads that do not take part they are ordinary locks."""

from __future__ import annotations

import threading
from types import TracebackType

from canwire.threads.keeper import NEVER
from canwire.threads.member import current
from canwire.threads.originals import allocate_lock

_LATE_NS = 1  # as every clock's: can-j1939 loops without end if it wakes up exactly at its deadline


class Lock:
    """Replaces threading.Lock, and so the lock in Condition, Event, Semaphore and RLock."""

    __slots__ = ("__weakref__", "_lock", "acquire_lock", "locked", "release", "release_lock")

    _lock: threading.Lock

    def __init__(self) -> None:
        self._use(allocate_lock())

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        if self._lock.acquire(False):
            return True
        me = current() if blocking else None
        if me is None:
            return self._lock.acquire(blocking, timeout)
        until_ns = min(me.company.end_ns(None if timeout == -1 else timeout), NEVER - _LATE_NS) + _LATE_NS
        answer = me.company.wait(me, self._take, until_ns, "a lock")
        return self._lock.acquire(True, timeout) if answer is None else answer

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._lock.release()

    def __repr__(self) -> str:
        return (
            f"<{'locked' if self._lock.locked() else 'unlocked'} canwire.threads.lock.Lock at {id(self):#x}>"
        )

    def _take(self) -> bool:
        return self._lock.acquire(False)

    def _use(self, lock: threading.Lock) -> None:
        self._lock = lock
        self.release = self.release_lock = lock.release
        self.locked = lock.locked
        self.acquire_lock = self.acquire

    def _at_fork_reinit(self) -> None:
        self._use(allocate_lock())
