"""The state of the view: the program, the threads of its windows, and the viewers that wait for changes."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire import CanwireError
from canwire.web.cancheck.program import CanCheck
from canwire.web.cancheck.running import Runner

if TYPE_CHECKING:
    from canwire import Hub
    from canwire.web.cancheck.program import Window


class Checking:
    """Windows with threads. Ends with `leave`, or when the hub is lost."""

    def __init__(self) -> None:
        self.program = CanCheck(self._tell)
        self._lock = threading.RLock()
        self._listeners: list[Callable[[], None]] = []
        self._runners: dict[Window, Runner] = {}

    def listen(self, changed: Callable[[], None]) -> None:
        """Call `changed` after every change, from any thread."""
        with self._lock:
            self._listeners.append(changed)

    def unlisten(self, changed: Callable[[], None]) -> None:
        with self._lock:
            self._listeners.remove(changed)

    def start(self, hub: Hub, port: str) -> None:
        self.program.start(hub, port)

    def open(self, *, receive: bool, send: bool) -> list[Window]:
        """Open windows on a new handle, and run them; raises CandrvError if no channel is left."""
        with self._lock:
            windows = self.program.open(receive=receive, send=send)
            for window in windows:
                self._runners[window] = Runner(window, self.program.changed)
            return windows

    def close(self, number: int) -> None:
        """Close the windows of this handle."""
        with self._lock:
            closing = [window for window in self._runners if window.number == number]
            runners = [self._runners.pop(window) for window in closing]
        for runner in runners:
            runner.stop()
        self.program.close(number)
        for runner in runners:
            runner.join()

    def leave(self) -> None:
        """Close all windows; a second call does nothing."""
        for number in {window.number for window in self.program.windows}:
            self.close(number)
        self.program.leave()

    def hub_lost(self) -> None:
        """Close everything after the hub was lost: the handles no longer exist, so errors of closing are ignored."""
        try:
            self.leave()
        except CanwireError:  # each of them says so of itself; what they held went with the hub
            self.program.leave()

    def _tell(self) -> None:
        with self._lock:
            listeners = list(self._listeners)
        for changed in listeners:
            changed()
