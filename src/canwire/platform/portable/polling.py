"""Waiting for any of many sockets with what every system has: kqueue on macOS and the BSDs, else select."""

from __future__ import annotations

import errno
import selectors
import sys
import threading
from typing import Any

_SELECT_TAKES = 512 if sys.platform == "win32" else 1024


class Poller:
    """Waits for any of many sockets; `READABLE` and `WRITABLE` are the bits of what it finds."""

    READABLE = selectors.EVENT_READ
    WRITABLE = selectors.EVENT_WRITE

    def __init__(self) -> None:
        kqueue: Any = getattr(selectors, "KqueueSelector", None)
        self._selector: selectors.BaseSelector = kqueue() if kqueue else selectors.SelectSelector()
        self._limited = kqueue is None

    def watch(self, descriptor: int, events: int) -> None:
        """From now on, or in place of the events before; raises OSError (EMFILE) where select takes no more."""
        if descriptor in self._selector.get_map():
            self._selector.modify(descriptor, events)
        elif self._limited and self._full(descriptor):
            raise OSError(errno.EMFILE, f"select watches {_SELECT_TAKES} sockets at most")
        else:
            self._selector.register(descriptor, events)

    def unwatch(self, descriptor: int) -> None:
        """Before it is closed; an unknown one is ignored."""
        if descriptor in self._selector.get_map():
            self._selector.unregister(descriptor)

    def wait(self, timeout: float | None) -> list[tuple[int, int]]:
        """Sockets and their events within `timeout` seconds (None: for ever). A broken one is readable, too."""
        if self._limited and not self._selector.get_map():  # Windows' select refuses to wait for nothing
            threading.Event().wait(timeout)
            return []
        return [(key.fd, events) for key, events in self._selector.select(timeout)]

    def close(self) -> None:
        self._selector.close()

    def _full(self, descriptor: int) -> bool:
        if sys.platform == "win32":  # it counts them; elsewhere their numbers must be small
            return len(self._selector.get_map()) >= _SELECT_TAKES
        return descriptor >= _SELECT_TAKES


def sharpen_sleep() -> None:
    """Let waits end on time: Windows looks at its clock every 15.6 ms unless somebody asks for 1 ms."""
    if sys.platform == "win32":
        import ctypes

        ctypes.windll.winmm.timeBeginPeriod(1)
