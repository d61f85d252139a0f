"""One connection to a hub for all Bus objects of a process, so that they share the cyclic list of a line."""

from __future__ import annotations

import os
import sys
import threading

import canwire
from canwire import Hub

_LONGEST_NAME = 64  # of a program, at the hub


class Hubs:
    """Connections by address, with the number of users of each; the last `release` closes it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._open: dict[tuple[int, str | None], Hub] = {}
        self._users: dict[Hub, int] = {}

    def acquire(self, address: str | None) -> Hub:
        """A connection, to `release` later; raises HubLost if no hub listens at a given address."""
        key = os.getpid(), address
        with self._lock:
            hub = self._open.get(key)
            if hub is None or hub.lost:
                hub = self._open[key] = canwire.connect(address, name=program_name())
            self._users[hub] = self._users.get(hub, 0) + 1
            return hub

    def release(self, hub: Hub) -> None:
        with self._lock:
            self._users[hub] -= 1
            if self._users[hub]:
                return
            del self._users[hub]
            self._open = {key: other for key, other in self._open.items() if other is not hub}
        hub.close()


def program_name() -> str:
    """The name that other programs read for this program."""
    script = os.path.basename(sys.argv[0] if sys.argv else "") or "python"
    return f"python-can: {script}"[:_LONGEST_NAME]


HUBS = Hubs()
