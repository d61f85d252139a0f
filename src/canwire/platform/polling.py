"""Waiting for any of many descriptors, by the best means of Linux."""

from __future__ import annotations

import select
import time
from typing import Any


class Poller:
    """Waits for any of many descriptors; `READABLE` and `WRITABLE` are bits of the events that it returns."""

    READABLE = select.POLLIN
    WRITABLE = select.POLLOUT

    def __init__(self) -> None:
        epoll = hasattr(select, "epoll")
        poll: Any = select.epoll() if epoll else select.poll()
        self._poll = poll
        self._per_second = 1 if epoll else 1000  # what their timeouts count in
        self._known: set[int] = set()
        # both wait whole milliseconds, select waits better, but only for descriptors below 1024
        own = poll.fileno() if epoll else 1024
        self._finer = [own] if own < 1024 else []

    def watch(self, descriptor: int, events: int) -> None:
        """Watch a descriptor for these events, which replace earlier ones."""
        if descriptor in self._known:
            self._poll.modify(descriptor, events)
        else:
            self._poll.register(descriptor, events)
            self._known.add(descriptor)

    def unwatch(self, descriptor: int) -> None:
        """Stop watching a descriptor, before it is closed; an unknown one is ignored."""
        if descriptor in self._known:
            self._known.remove(descriptor)
            self._poll.unregister(descriptor)

    def wait(self, timeout: float | None) -> list[tuple[int, int]]:
        """Descriptors and their events within `timeout` seconds (None: forever). A broken one counts as readable."""
        if timeout is None or timeout <= 0 or not self._finer:
            return self._found(timeout)
        if timeout > _LONG_S:  # most such waits end long before: then this is one system call, not two
            end_s = time.monotonic() + timeout
            found = self._found(timeout - _ROUNDED_S)
            if found:
                return found
            timeout = max(0.0, end_s - time.monotonic())
        return self._found(0) if select.select(self._finer, (), (), timeout)[0] else []

    def _found(self, timeout: float | None) -> list[tuple[int, int]]:
        found: list[tuple[int, int]] = self._poll.poll(
            None if timeout is None else timeout * self._per_second
        )
        return found

    def close(self) -> None:
        self._known.clear()
        if hasattr(self._poll, "close"):
            self._poll.close()


_LONG_S = 0.05
_ROUNDED_S = 0.002  # more than a wait in whole milliseconds is late by
