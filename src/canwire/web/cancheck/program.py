"""CanCheck as a program: a port and the open windows, shared by all viewers of a page.

It uses the line through canwire.candrv. It has no thread: running.py runs the windows; tests call `take` and `fire`
themselves. Source: CANDRV manual, 10.4.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire import BadValue, CanwireError, candrv
from canwire.web.cancheck.echoes import Echoes
from canwire.web.cancheck.port import Port
from canwire.web.cancheck.receive import ReceiveWindow
from canwire.web.cancheck.send import SendWindow

if TYPE_CHECKING:
    from canwire import Hub

FIRST_HANDLE, STEP = 0x100, 4  # as Windows numbers them
Window = ReceiveWindow | SendWindow


class CanCheck:
    """CanCheck, which has an open port between `start` and `leave`.

    `changed` is called, from any thread, after every change. Methods raise CandrvError with the driver's message, with
    code 1450 if no virtual channel is left.
    """

    def __init__(self, changed: Callable[[], None] = lambda: None) -> None:
        self.changed = changed
        self._lock = threading.RLock()
        self._hub: Hub | None = None
        self._port: Port | None = None
        self._windows: list[Window] = []
        self._next = FIRST_HANDLE

    @property
    def running(self) -> bool:
        return self._port is not None

    @property
    def port(self) -> Port:
        """The open port; raises BadValue while CanCheck is not running."""
        port = self._port
        if port is None:
            raise BadValue("CanCheck is not running; start it first")
        return port

    @property
    def windows(self) -> list[Window]:
        """The open windows in the order in which they were opened."""
        with self._lock:
            return list(self._windows)

    def start(self, hub: Hub, name: str) -> None:
        """Open a port to query it; a previous port is closed, but its windows stay open."""
        with self._lock:
            port = Port(hub, name)
            before, self._port, self._hub = self._port, port, hub
            if before is not None:
                before.close()
        self.changed()

    def open(self, *, receive: bool, send: bool) -> list[Window]:
        """Open one more handle on the port, with its windows; a pair shares the handle. No threads are started."""
        with self._lock:
            name, hub = self.port.name, self._hub
            handle = candrv.open(name, read=receive, write=send, hub=hub)
            number, self._next = self._next, self._next + STEP
            windows: list[Window] = []
            try:
                if send:
                    echoes = Echoes(handle.device)
                    windows.append(SendWindow(number, handle, echoes, changed=self.changed))
                if receive:
                    windows.append(ReceiveWindow(number, handle, self.changed))
            except CanwireError:
                handle.close()
                raise
            self._windows += windows
        self.changed()
        return windows

    def window(self, number: int, kind: str) -> Window:
        """Return an open window; raises BadValue if it is not open."""
        for window in self.windows:
            if window.number == number and window.kind == kind:
                return window
        raise BadValue(f"the window of handle {number:X} is not open any more")

    def receiver(self, number: int) -> ReceiveWindow:
        window = self.window(number, "receive")
        assert isinstance(window, ReceiveWindow)
        return window

    def sender(self, number: int) -> SendWindow:
        window = self.window(number, "send")
        assert isinstance(window, SendWindow)
        return window

    def close(self, number: int) -> None:
        """Close the windows of a handle, and the handle."""
        with self._lock:
            closing = [one for one in self._windows if one.number == number]
            self._windows = [one for one in self._windows if one.number != number]
        for window in closing:
            window.close()
        self.changed()

    def leave(self) -> None:
        """End the program; a second call does nothing."""
        for number in {window.number for window in self.windows}:
            self.close(number)
        with self._lock:
            port, self._port, self._hub = self._port, None, None
        if port is not None:
            port.close()
        self.changed()
