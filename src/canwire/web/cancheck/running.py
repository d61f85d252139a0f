"""Threads of a window: one lists received messages; in a send window a second one fires its generators."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire import CanwireError
from canwire.web.cancheck.send import SendWindow
from canwire.web.words import Trouble

if TYPE_CHECKING:
    from canwire.web.cancheck.program import Window


class Runner:
    """Runs one window until it is closed, or until its board or hub is lost; `trouble` of the window is then set."""

    def __init__(self, window: Window, changed: Callable[[], None]) -> None:
        self._window = window
        self._changed = changed
        self._ends = threading.Event()
        jobs = [self._take] + ([self._fire] if isinstance(window, SendWindow) else [])
        self._threads = [threading.Thread(target=job, name=f"CanCheck {window.kind}") for job in jobs]
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """Request the end of the threads; call this before the window is closed."""
        self._ends.set()

    def join(self) -> None:
        """Wait for the end of the threads; call this after the window was closed."""
        if isinstance(self._window, SendWindow):
            self._window.generators.wake()
        for thread in self._threads:
            thread.join()

    def _take(self) -> None:
        window = self._window
        while not self._ends.is_set():
            try:
                window.wait()
                window.take()
            except CanwireError as error:
                self._tell(error)
                return

    def _fire(self) -> None:
        assert isinstance(self._window, SendWindow)
        generators = self._window.generators
        while not self._ends.is_set():
            try:
                pause_ns = generators.fire()
            except CanwireError as error:  # the clock is the hub's
                self._tell(error)
                return
            if pause_ns is None or pause_ns:
                generators.wait(pause_ns)

    def _tell(self, error: CanwireError) -> None:
        if not self._ends.is_set():
            self._window.trouble = Trouble.of(error)
            self._changed()
