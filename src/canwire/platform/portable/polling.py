"""Waiting for any of many sockets on every system: with kqueue on macOS and the BSDs, otherwise with select."""

from __future__ import annotations

import errno
import selectors
import sys
import threading
from typing import Any

_SELECT_TAKES = 512 if sys.platform == "win32" else 1024


class Poller:
    """Waits for any of many sockets; `READABLE` and `WRITABLE` are bits of the events that it returns."""

    READABLE = selectors.EVENT_READ
    WRITABLE = selectors.EVENT_WRITE

    def __init__(self) -> None:
        kqueue: Any = getattr(selectors, "KqueueSelector", None)
        self._selector: selectors.BaseSelector = kqueue() if kqueue else selectors.SelectSelector()
        self._limited = kqueue is None
        self._unwatched = 0  # how often

    def watch(self, descriptor: int, events: int) -> None:
        """Watch a socket for these events, which replace earlier ones; raises OSError (EMFILE) if select is full."""
        if descriptor in self._selector.get_map():
            self._selector.modify(descriptor, events)
        elif self._limited and self._full(descriptor):
            raise OSError(errno.EMFILE, f"select watches {_SELECT_TAKES} sockets at most")
        else:
            self._selector.register(descriptor, events)

    def unwatch(self, descriptor: int) -> None:
        """Stop watching a socket, before it is closed; an unknown one is ignored."""
        if descriptor in self._selector.get_map():
            self._selector.unregister(descriptor)
            self._unwatched += 1

    def wait(self, timeout: float | None) -> list[tuple[int, int]]:
        """Sockets and their events within `timeout` seconds (None: forever). A broken one counts as readable."""
        if self._limited and not self._selector.get_map():  # Windows' select refuses to wait for nothing
            threading.Event().wait(timeout)
            return []
        before = self._unwatched
        try:
            return [(key.fd, events) for key, events in self._selector.select(timeout)]
        except OSError:
            if self._unwatched == before:
                raise
            return []  # another thread has unwatched and closed one as this wait began

    def close(self) -> None:
        self._selector.close()

    def _full(self, descriptor: int) -> bool:
        if sys.platform == "win32":  # it counts them; elsewhere their numbers must be small
            return len(self._selector.get_map()) >= _SELECT_TAKES
        return descriptor >= _SELECT_TAKES


def sharpen_sleep() -> None:
    """Make waits end on time: Windows checks its clock every 15.6 ms unless a program requests 1 ms."""
    if sys.platform == "win32":
        import ctypes

        ctypes.windll.winmm.timeBeginPeriod(1)
