"""Buses that a program forgets to shut down are let go at its end, while the threads that this takes still run.

python-can's own way, `__del__`, may come after that: then nobody takes in a hub's answer any more.
"""

from __future__ import annotations

import atexit
import logging
import os
from typing import Protocol
from weakref import WeakSet

_LOG = logging.getLogger("can.bus")  # python-can's, with its words


class Ending(Protocol):
    """bus.py's buses."""

    def shutdown(self) -> None: ...
    def leave_to_parent(self) -> None: ...


class OpenBuses:
    """Those of this process; a fork of it has none of them."""

    def __init__(self) -> None:
        self._buses: WeakSet[Ending] = WeakSet()

    def add(self, bus: Ending) -> None:
        self._buses.add(bus)

    def discard(self, bus: Ending) -> None:
        self._buses.discard(bus)

    def end(self) -> None:
        """What is sent goes out, everything is given back."""
        for bus in list(self._buses):
            _LOG.warning("%s was not properly shut down", type(bus).__name__)
            bus.shutdown()

    def leave_to_parent(self) -> None:
        """In a fork of the process: they are the parent's, and so is everything that waits in them."""
        for bus in list(self._buses):
            bus.leave_to_parent()
        self._buses = WeakSet()


OPEN_BUSES = OpenBuses()
atexit.register(OPEN_BUSES.end)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=OPEN_BUSES.leave_to_parent)
