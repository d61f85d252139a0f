"""The thread of an engine: it waits for input, passes it on, and lets time pass."""

from __future__ import annotations

import heapq
import itertools
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

from canwire.hub.owner.pace import RealPace
from canwire.platform import EventDescriptor, Poller, sharpen_sleep

_AFTER_FAILURE_S = 0.01  # a bus that fails at every turn must not take the whole processor
_WRITABLE = Poller.WRITABLE


class HasFileno(Protocol):
    """An object that can be watched."""

    def fileno(self) -> int: ...


class Runs(Protocol):
    """The methods of the engine that its thread uses."""

    def report(self, error: BaseException) -> None: ...
    def run_posted(self) -> None: ...
    def finish(self) -> None: ...


class Watched:
    """The callbacks of a descriptor; `active` until it is unwatched."""

    def __init__(self, readable: Callable[[], object], writable: Callable[[], object] | None) -> None:
        self.readable = readable
        self.writable = writable
        self.active = True


class Loop:
    """The work of the engine's thread: input first, then posted work, then time."""

    def __init__(self, engine: Runs, pace: RealPace, posted: deque[Callable[[], object]]) -> None:
        self.pace = pace
        self.stopping = False
        self.wake = EventDescriptor()
        self._engine = engine
        self._posted = posted
        self._poller = Poller()
        self._watched: dict[int, Watched] = {}
        self._reminders: list[tuple[float, int, Callable[[], object]]] = []  # a heap
        self._numbers = itertools.count()
        self.watch(self.wake, self.wake.clear)
        self.thread = threading.Thread(target=self.run, name="canwire-hub", daemon=True)

    def watch(
        self, source: HasFileno, readable: Callable[[], object], writable: Callable[[], object] | None = None
    ) -> None:
        """Call back whenever `source` is readable, or writable; a second call replaces these."""
        before = self._watched.get(source.fileno())
        if before is not None:
            before.active = False
        self._watched[source.fileno()] = Watched(readable, writable)
        self._poller.watch(source.fileno(), Poller.READABLE | (Poller.WRITABLE if writable else 0))

    def unwatch(self, source: HasFileno) -> None:
        """Stop watching immediately; an unknown source is ignored."""
        watched = self._watched.pop(source.fileno(), None)
        if watched is not None:
            watched.active = False
            self._poller.unwatch(source.fileno())

    def remind(self, seconds: float, work: Callable[[], object]) -> None:
        """Call back once after this many seconds of the monotonic clock."""
        heapq.heappush(self._reminders, (time.monotonic() + seconds, next(self._numbers), work))

    def run(self) -> None:
        """The thread's work, until `stopping`."""
        sharpen_sleep()
        try:
            timeout: float | None = 0.0
            while not self.stopping:
                timeout = self._turn(timeout)
        finally:
            with self.pace.holding():
                self._engine.finish()
            self._poller.close()
            self.wake.close()

    def _turn(self, timeout: float | None) -> float | None:
        """Wait for input for this many seconds, handle it, let time pass; returns how long to wait next."""
        if self._reminders:
            timeout = self._until_reminder(timeout)
        found = self._poller.wait(0 if self._posted else timeout)
        if not self.pace.held:
            return self._work(found)
        with self.pace.holding():
            return self._work(found)

    def _work(self, found: list[tuple[int, int]]) -> float | None:
        ready = [(self._watched[descriptor], events) for descriptor, events in found]
        if ready or self._posted:
            try:
                self.pace.catch_up()
            except Exception as error:
                self._engine.report(error)
            for watched, events in ready:
                self._handle(watched, events)
            if self._posted:
                self._engine.run_posted()
        if self._reminders:
            self._remind()
        timeout: float | None = _AFTER_FAILURE_S
        try:
            timeout = self.pace.run()
        except Exception as error:
            self._engine.report(error)
        try:
            self.pace.tell()
        except Exception as error:
            self._engine.report(error)
        return timeout

    def _until_reminder(self, timeout: float | None) -> float:
        left = max(0.0, self._reminders[0][0] - time.monotonic())
        return left if timeout is None else min(timeout, left)

    def _remind(self) -> None:
        while self._reminders and self._reminders[0][0] <= time.monotonic():
            work = heapq.heappop(self._reminders)[2]
            try:
                work()
            except Exception as error:
                self._engine.report(error)

    def _handle(self, watched: Watched, events: int) -> None:
        try:
            if watched.active and events & ~_WRITABLE:
                watched.readable()
            if watched.active and watched.writable is not None and events & _WRITABLE:
                watched.writable()
        except Exception as error:
            self._engine.report(error)
