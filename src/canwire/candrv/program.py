"""The state of one program: its connection to the hub, the numbers of its handles, the last error of each thread."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import canwire
from canwire.candrv.constants import Win32Error
from canwire.candrv.errors import CandrvError

if TYPE_CHECKING:
    from canwire import Hub
    from canwire.candrv.handle.handle import Handle

_FIRST_HANDLE, _STEP = 0x100, 4  # Windows' own are multiples of four, too


class LastError(threading.local):
    """The value of GetLastError, for each thread."""

    code = 0


class Program:
    """The state of one process. The connection stays open, so that a device keeps its settings between handles."""

    def __init__(self) -> None:
        self.last_error = LastError()
        self._lock = threading.Lock()
        self._hub: Hub | None = None
        self._handles: dict[int, Handle] = {}
        self._next = _FIRST_HANDLE

    def hub(self) -> Hub:
        with self._lock:
            if self._hub is None or self._hub.lost:
                self._hub = canwire.connect()
            return self._hub

    def use(self, hub: Hub | None) -> None:
        """Open devices on this hub from now on; None: on the hub of `canwire.connect()`."""
        with self._lock:
            self._hub = hub

    def add(self, handle: Handle) -> int:
        with self._lock:
            number, self._next = self._next, self._next + _STEP
            self._handles[number] = handle
            return number

    def handle(self, number: int) -> Handle:
        """The handle with this number; raises ERROR_INVALID_HANDLE if there is none."""
        handle = self._handles.get(number)
        if handle is None:
            raise CandrvError(Win32Error.ERROR_INVALID_HANDLE, f"handle {number!r:.20}")
        return handle

    def remove(self, number: int) -> Handle:
        """Remove the handle with this number and return it; raises ERROR_INVALID_HANDLE if there is none."""
        with self._lock:
            handle = self._handles.pop(number, None)
        if handle is None:
            raise CandrvError(Win32Error.ERROR_INVALID_HANDLE, f"handle {number!r:.20}")
        return handle


PROGRAM = Program()


def program_hub() -> Hub:
    """The hub of this program."""
    return PROGRAM.hub()
