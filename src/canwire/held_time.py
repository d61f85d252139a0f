"""Virtual time at a given pace: it passes at most `factor` times as quickly as the wall clock."""

from __future__ import annotations

import time

from canwire.timeline import NEVER, Timeline

LATE_NS = 100_000_000  # of the wall clock: a longer delay is skipped, not made up for
_LONGEST_WAIT_S = 3600.0  # systems limit the length of a wait
_LOOK_S = 0.02  # of the wall clock: how often a waiting thread checks whether the pace has changed


class HeldTime:
    """`factor` is the number of virtual seconds in one second of the wall clock; 0: as quickly as possible.

    Virtual time does not pass while the program computes, so it falls behind the clock. Delays up to `LATE_NS` are
    made up for. After longer ones (a breakpoint, a suspended machine, slow buses) time continues from where it was.
    """

    def __init__(self) -> None:
        self.factor = 0.0
        self._began: tuple[int, int] | None = None  # virtual time and clock, from where on the factor counts
        self._rest_s = 0.0

    def hold(self, factor: float) -> None:
        """Use this factor from now on."""
        self.factor, self._began = factor, None

    def limit_ns(self, now_ns: int, next_ns: int, clock_ns: int) -> int:
        """The limit up to which time may pass at `clock_ns`; it is `now_ns` now, and `next_ns` is the next event."""
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
        """The real time in seconds of this span of virtual time, at most `_LONGEST_WAIT_S`; 0 if `factor` is 0."""
        return min(span_ns / self.factor / 1e9, _LONGEST_WAIT_S) if self.factor else 0.0

    # for code that lets time pass in its thread

    @property
    def resting(self) -> bool:
        """The last run was cut short: more time may pass later."""
        return self._rest_s > 0

    def run(self, timeline: Timeline, until_ns: int) -> bool:
        """Timeline.run_until, up to the limit at this moment; False if that is too early: call `rest` next."""
        self._rest_s = 0.0
        limit_ns = self._limit_now_ns(timeline, until_ns)
        if limit_ns >= until_ns:
            return timeline.run_until(until_ns)
        if timeline.run_until(limit_ns):
            next_ns = min(until_ns, timeline.next_ns())
            self._rest_s = min(self.wait_s(next_ns - timeline.now_ns), _LOOK_S)
        return False

    def rest(self) -> bool:
        """Wait until more time may pass, if the limit cut the last run short; returns whether it did."""
        rest_s, self._rest_s = self._rest_s, 0.0
        if rest_s > 0:
            time.sleep(rest_s)
        return rest_s > 0

    def run_through(self, timeline: Timeline, until_ns: int) -> bool:
        """Timeline.run_until at the given pace: waits for the wall clock whenever time may not pass yet."""
        while not self.run(timeline, until_ns):
            if not self.rest():
                return False
        return True

    def run_until_idle(self, timeline: Timeline, until_ns: int) -> bool:
        """Timeline.run_until_idle at the given pace: waits for the wall clock whenever time may not pass yet."""
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
