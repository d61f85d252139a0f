"""Shuts down the buses that a program has left open, at its end, while the threads that this needs still run.

python-can's `__del__` may run later, when no thread receives answers of a hub.
"""

from __future__ import annotations

import atexit
import logging
import os
import threading
from typing import Protocol
from weakref import WeakSet

_LOG = logging.getLogger("can.bus")  # python-can's, with its words


class Ending(Protocol):
    """The methods of bus.py's buses that are called at the end."""

    def shutdown(self) -> None: ...
    def leave_to_parent(self) -> None: ...


class OpenBuses:
    """The open buses of this process; a fork of it has none of them."""

    def __init__(self) -> None:
        self._buses: WeakSet[Ending] = WeakSet()
        self._over = False

    def add(self, bus: Ending) -> None:
        self._buses.add(bus)

    def discard(self, bus: Ending) -> None:
        self._buses.discard(bus)

    def end(self) -> None:
        """Shut down all buses: waiting messages are sent, and everything is closed."""
        self._over = True
        for bus in list(self._buses):
            _LOG.warning("%s was not properly shut down", type(bus).__name__)
            bus.shutdown()

    def outlasts(self, timeout: float | None) -> bool:
        """Whether `end` was called; if so, after this many seconds.

        A thread that receives does so until the process ends. With an error instead, python-can's Notifier prints a
        traceback, and a daemon thread that prints while the interpreter ends aborts the process.
        """
        if self._over:
            threading.Event().wait(timeout)
        return self._over

    def leave_to_parent(self) -> None:
        """In a fork of the process: the buses and the messages in them belong to the parent."""
        for bus in list(self._buses):
            bus.leave_to_parent()
        self._buses = WeakSet()


OPEN_BUSES = OpenBuses()
atexit.register(OPEN_BUSES.end)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=OPEN_BUSES.leave_to_parent)
