"""The only file that knows operating systems: event descriptors and named shared memory.

Linux has eventfd; elsewhere a pipe stands in for it, same calls, two descriptors.
"""

from __future__ import annotations

import contextlib
import os
import select
import sys
import threading
from multiprocessing import resource_tracker
from multiprocessing.shared_memory import SharedMemory


class EventDescriptor:
    """A wake-up that threads and processes share: `signal` it, `wait` for it, select on `fileno()`."""

    def __init__(self) -> None:
        if hasattr(os, "eventfd"):
            self._read = self._write = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        else:
            self._read, self._write = os.pipe()
            os.set_blocking(self._read, False)
            os.set_blocking(self._write, False)
        self._closed = False

    def fileno(self) -> int:
        return self._read

    def signal(self) -> None:
        """Wake whoever waits; signals that nobody has consumed yet count as one."""
        with contextlib.suppress(BlockingIOError):  # full: the reader has a wake-up pending anyway
            os.write(self._write, b"\x01\0\0\0\0\0\0\0")

    def wait(self, timeout: float | None = None) -> bool:
        """Consume a signal, waiting `timeout` seconds for it (None: for ever); False when none came."""
        readable, _, _ = select.select([self._read], [], [], timeout)
        if readable:
            with contextlib.suppress(BlockingIOError):  # another waiter was quicker
                os.read(self._read, 4096)
                return True
        return False

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            for descriptor in {self._read, self._write}:
                os.close(descriptor)


def create_shared_memory(name: str, size: int) -> SharedMemory:
    """A new named block of zeros; raises FileExistsError if the name is taken."""
    return SharedMemory(name, create=True, size=size)


def attach_shared_memory(name: str) -> SharedMemory:
    """An existing block; its creator alone removes it. Raises FileNotFoundError."""
    if sys.version_info >= (3, 13):
        return SharedMemory(name, track=False)
    with _ATTACHING:
        # before 3.13 attaching registers for removal too, and the first process to end would remove it
        register, resource_tracker.register = resource_tracker.register, _no_registration
        try:
            return SharedMemory(name)
        finally:
            resource_tracker.register = register


def _no_registration(name: object, rtype: str) -> None:
    """Stands in for the resource tracker's while somebody else's memory is attached."""


_ATTACHING = threading.Lock()
