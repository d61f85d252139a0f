"""A loop whose time passes when a test says so."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable

from canwire.socketcan.loop import Loop, Timer


class Clock(Loop):
    """Of loop.py's it has the timers alone."""

    def __init__(self) -> None:
        self.now_s = 100.0
        self._queue: list[tuple[float, int, Timer]] = []
        self._numbers = itertools.count()

    def clock_s(self) -> float:  # type: ignore[override]
        return self.now_s

    def call_at(self, due_s: float, call: Callable[[], object]) -> Timer:
        timer = Timer(due_s, call)
        heapq.heappush(self._queue, (due_s, next(self._numbers), timer))
        return timer

    def run_for(self, seconds: float) -> None:
        end_s = self.now_s + seconds
        while self._queue and self._queue[0][0] <= end_s + 1e-9:
            due_s, _, timer = heapq.heappop(self._queue)
            self.now_s = max(self.now_s, due_s)
            if timer.call is not None:
                timer.call()
        self.now_s = end_s
