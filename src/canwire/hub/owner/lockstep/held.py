"""A hub's virtual time that is held to the wall clock: it passes so many times as quickly, and never more so."""

from __future__ import annotations

from canwire.timeline import NEVER

LATE_NS = 100_000_000  # of the clock: what time is late by beyond this is left out, not made up for
_LONGEST_WAIT_S = 3600.0  # systems do not count for ever


class HeldTime:
    """`factor` is how many seconds pass in one of the clock; 0: time passes as quickly as it can.

    While a program computes time stands, so it falls behind the clock. A little of that is made up for; after a
    breakpoint, a suspended machine, or with buses that are slower than the clock, time continues from where it was.
    """

    def __init__(self) -> None:
        self.factor = 0.0
        self._began: tuple[int, int] | None = None  # hub's time and clock, from where on the factor counts

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
        return min(span_ns / self.factor / 1e9, _LONGEST_WAIT_S)
