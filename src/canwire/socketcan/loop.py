"""The server's only thread: descriptors and timers, each with a callback."""

from __future__ import annotations

import heapq
import itertools
import select
import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

READABLE, WRITABLE, HUNG_UP = 1, 4, 8 | 16  # as epoll has them
URGENT = 2  # EPOLLPRI, which nothing here has: served while a program runs that keeps one time with others
_MOST_EVENTS = 256
_FEW = 64  # timers among which nobody looks for cancelled ones


class Timer:
    """A call that is due at a time; `cancel` may be called several times."""

    __slots__ = ("_due_s", "call")

    def __init__(self, due_s: float, call: Callable[[], object]) -> None:
        self._due_s = due_s
        self.call: Callable[[], object] | None = call

    @property
    def due_s(self) -> float:
        return self._due_s

    def cancel(self) -> None:
        self.call = None


class Waiter(Protocol):
    """Waits for descriptors. `watch` without events is allowed: then only a broken connection may be reported."""

    def watch(self, descriptor: int, events: int) -> None: ...
    def change(self, descriptor: int, events: int) -> None: ...
    def forget(self, descriptor: int) -> None: ...
    def wait(self, seconds: float | None) -> list[tuple[int, int]]: ...
    def close(self) -> None: ...


class Polled:
    """Waits with epoll, on Linux."""

    def __init__(self) -> None:
        self._epoll = select.epoll()
        self.watch, self.change, self.forget = (
            self._epoll.register,
            self._epoll.modify,
            self._epoll.unregister,
        )
        self.close, self.fileno = self._epoll.close, self._epoll.fileno

    def wait(self, seconds: float | None) -> list[tuple[int, int]]:
        """Descriptors and their events; empty after `seconds` (None: no limit)."""
        if seconds is None:
            return self._epoll.poll(-1, _MOST_EVENTS)
        # epoll counts in whole milliseconds, select in microseconds
        if seconds and not select.select([self._epoll], [], [], seconds)[0]:
            return []
        return self._epoll.poll(0, _MOST_EVENTS)


class Gathering:
    """The pause before the next check for frames: none, unless frames arrive so fast that wake-ups cost too much.

    A request and its answer need no pause: at 1 Mbit/s they are 0.3 ms apart. A full bus has a frame every 0.13 ms, and
    a processor would do nothing but wake up.
    """

    _WINDOW = 16  # frames ...
    _BUSY_S = 0.0032  # ... in so short a time: it is busy
    _PAUSE_S = 0.001
    _FEW = 4  # found after a pause: it is not busy any more

    def __init__(self, clock_s: Callable[[], float]) -> None:
        self._clock_s = clock_s
        self._found = 0
        self._since_s = 0.0
        self._pauses = False

    def pause_s(self, count: int) -> float:
        """Seconds, after a check that found `count`; 0: wait for the next event."""
        if self._pauses:
            self._pauses = count >= self._FEW
        else:
            self._found += count
            if self._found >= self._WINDOW:
                now_s = self._clock_s()
                self._pauses = now_s - self._since_s < self._BUSY_S * self._found / self._WINDOW
                self._found, self._since_s = 0, now_s
        return self._PAUSE_S if self._pauses else 0.0


class Loop:
    """Runs until `stop`; times are those of `clock_s`, seconds. `waiter` None: Linux' own."""

    def __init__(self, waiter: Waiter | None = None, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._waiter = waiter or Polled()
        self.clock_s = clock_s
        self._calls: dict[int, Callable[[int], object]] = {}
        self._timers: list[tuple[float, int, Timer]] = []
        self._most_timers = _FEW  # with more of them, cancelled ones go
        self._serials = itertools.count()
        self._soon: deque[Callable[[], object]] = deque()
        self._running = False

    def watch(self, descriptor: int, events: int, call: Callable[[int], object]) -> None:
        """Call `call(events)` whenever these events occur; a second call for a descriptor replaces the first one."""
        if descriptor in self._calls:
            self._waiter.change(descriptor, events)
        else:
            self._waiter.watch(descriptor, events)
        self._calls[descriptor] = call

    def forget(self, descriptor: int) -> None:
        """Stop watching a descriptor; call this before it is closed. A second call has no effect."""
        if self._calls.pop(descriptor, None) is not None:
            self._waiter.forget(descriptor)

    def call_at(self, due_s: float, call: Callable[[], object]) -> Timer:
        timer = Timer(due_s, call)
        if len(self._timers) >= self._most_timers:
            self._timers = [entry for entry in self._timers if entry[2].call is not None]
            heapq.heapify(self._timers)
            self._most_timers = max(_FEW, 2 * len(self._timers))
        heapq.heappush(self._timers, (due_s, next(self._serials), timer))
        return timer

    def call_in(self, seconds: float, call: Callable[[], object]) -> Timer:
        return self.call_at(self.clock_s() + seconds, call)

    def soon(self, call: Callable[[], object]) -> None:
        """Call this in the next turn, after all descriptors that are ready then."""
        self._soon.append(call)

    def stop(self) -> None:
        self._running = False

    def run(self) -> None:
        self._running = True
        while self._running:
            self._turn()

    def close(self) -> None:
        self._waiter.close()

    def _turn(self) -> None:
        wait_s = 0.0 if self._soon else self._seconds_left()
        for descriptor, events in self._waiter.wait(wait_s):
            if descriptor in self._calls:  # an earlier one of these may have ended it
                self._calls[descriptor](events)
        for _ in range(len(self._soon)):
            self._soon.popleft()()
        now_s = self.clock_s()
        while self._timers and self._timers[0][0] <= now_s:
            call = heapq.heappop(self._timers)[2].call
            if call is not None:
                call()

    def _seconds_left(self) -> float | None:
        while self._timers and self._timers[0][2].call is None:
            heapq.heappop(self._timers)
        return max(0.0, self._timers[0][0] - self.clock_s()) if self._timers else None
