"""Virtual time that is held to the wall clock: it passes so many times as quickly, and never more so."""

from __future__ import annotations

import time

from canwire.timeline import NEVER, Timeline

LATE_NS = 100_000_000  # of the clock: what time is late by beyond this is left out, not made up for
_LONGEST_WAIT_S = 3600.0  # systems do not count for ever
_LOOK_S = 0.02  # of the clock: who rests sees that often whether the pace is another one


class HeldTime:
    """`factor` is how many seconds pass in one of the clock; 0: time passes as quickly as it can.

    While a program computes time stands, so it falls behind the clock. A little of that is made up for; after a
    breakpoint, a suspended machine, or with buses that are slower than the clock, time continues from where it was.
    """

    def __init__(self) -> None:
        self.factor = 0.0
        self._began: tuple[int, int] | None = None  # virtual time and clock, from where on the factor counts
        self._rest_s = 0.0

    def hold(self, factor: float) -> None:
        """From now on, in place of what was."""
        self.factor, self._began = factor, None

    def limit_ns(self, now_ns: int, next_ns: int, clock_ns: int) -> int:
        """Until when time may pass at this moment of the clock; it is `now_ns`, and `next_ns` is what it waits for."""
        if not self.factor:
            return NEVER
        if self._began is None:
            self._began = now_ns, clock_ns
        limit_ns = self._began[0] + int((clock_ns - self._began[1]) * self.factor)
        if limit_ns - max(now_ns, next_ns) > LATE_NS * self.factor:
            self._began = now_ns, clock_ns
            return now_ns
        return max(now_ns, limit_ns)

    def wait_s(self, span_ns: int) -> float:
        """How long such a span lasts by the clock."""
        return min(span_ns / self.factor / 1e9, _LONGEST_WAIT_S) if self.factor else 0.0

    # for who lets time pass in its own thread

    @property
    def resting(self) -> bool:
        """The last run was cut short: more time may pass later."""
        return self._rest_s > 0

    def run(self, timeline: Timeline, until_ns: int) -> bool:
        """Timeline.run_until as far as it may pass at this moment; where that is not far enough, `rest` is next."""
        self._rest_s = 0.0
        limit_ns = self._limit_now_ns(timeline, until_ns)
        if limit_ns >= until_ns:
            return timeline.run_until(until_ns)
        if timeline.run_until(limit_ns):
            next_ns = min(until_ns, timeline.next_ns())
            self._rest_s = min(self.wait_s(next_ns - timeline.now_ns), _LOOK_S)
        return False

    def rest(self) -> bool:
        """Wait by the clock until more time may pass, if the last run was cut short for that; was it?"""
        rest_s, self._rest_s = self._rest_s, 0.0
        if rest_s > 0:
            time.sleep(rest_s)
        return rest_s > 0

    def run_through(self, timeline: Timeline, until_ns: int) -> bool:
        """Timeline.run_until, for as long by the clock as that takes."""
        while not self.run(timeline, until_ns):
            if not self.rest():
                return False
        return True

    def run_until_idle(self, timeline: Timeline, until_ns: int) -> bool:
        """Timeline.run_until_idle, for as long by the clock as that takes."""
        while not timeline.run_until_idle(min(until_ns, limit_ns := self._limit_now_ns(timeline, until_ns))):
            next_ns = timeline.next_ns()
            if limit_ns >= until_ns or next_ns > until_ns:
                return False
            self._rest_s = min(self.wait_s(next_ns - limit_ns), _LOOK_S)
            self.rest()
        return True

    def _limit_now_ns(self, timeline: Timeline, until_ns: int) -> int:
        if not self.factor:
            return NEVER
        return self.limit_ns(timeline.now_ns, min(until_ns, timeline.next_ns()), time.monotonic_ns())
