"""How busy a bus is: busy bit times over elapsed bit times, in a rolling second."""

from __future__ import annotations

BUCKET_NS = 100_000_000
BUCKETS = 10
_BUCKET_NS = BUCKET_NS
_LONG_NS = 2 * BUCKETS * BUCKET_NS


class BusLoad:
    """Adds up busy time in buckets of 100 ms; ten of them (1 s) are the window.

    `busy_ns` is the sum since the start; `peak` the busiest bucket so far, 0..100 %.
    """

    def __init__(self) -> None:
        self.busy_ns = 0
        self._bucket_end_ns = BUCKET_NS
        self._bucket_ns = 0
        self._fullest_ns = 0
        self._past = [0] * BUCKETS

    def add(self, start_ns: int, end_ns: int) -> None:
        """Add busy time from `start_ns` to `end_ns`; calls come in order of time and never overlap."""
        self.busy_ns += end_ns - start_ns
        if end_ns > self._bucket_end_ns or start_ns < self._bucket_end_ns - _BUCKET_NS:
            self._roll(start_ns, end_ns)
        else:
            self._bucket_ns += end_ns - start_ns

    def percent(self, now_ns: int) -> float:
        """Load over the last second (or since the start, if that is less), 0..100."""
        self._advance(now_ns)
        in_bucket = BUCKET_NS - (self._bucket_end_ns - now_ns)
        number = self._bucket_end_ns // BUCKET_NS - 1
        full = min(number, BUCKETS - 1)
        busy = self._bucket_ns + sum(self._past[(number - 1 - k) % BUCKETS] for k in range(full))
        elapsed = full * BUCKET_NS + in_bucket
        return min(100.0, 100.0 * busy / elapsed) if elapsed > 0 else 0.0

    def peak(self) -> float:
        """The busiest 100 ms so far, 0..100 %."""
        return 100.0 * max(self._fullest_ns, self._bucket_ns) / BUCKET_NS

    def _roll(self, start_ns: int, end_ns: int) -> None:
        self._advance(start_ns)
        start_ns = max(
            start_ns, self._bucket_end_ns - BUCKET_NS
        )  # what was looked at already stays as it was
        if (
            end_ns - start_ns > _LONG_NS
        ):  # busy throughout: the buckets before the last of these are not asked for
            start_ns = end_ns - _LONG_NS
            self._advance(start_ns)
        while end_ns > self._bucket_end_ns:
            edge_ns = self._bucket_end_ns
            self._bucket_ns += edge_ns - start_ns
            start_ns = edge_ns
            self._advance(edge_ns + 1)
        self._bucket_ns += max(0, end_ns - start_ns)

    def _advance(self, now_ns: int) -> None:
        """Close every bucket that ended before `now_ns`."""
        behind = (now_ns - 1 - self._bucket_end_ns) // BUCKET_NS + 1 if now_ns > self._bucket_end_ns else 0
        for _ in range(min(behind, BUCKETS + 1)):
            number = self._bucket_end_ns // BUCKET_NS - 1
            self._past[number % BUCKETS] = self._bucket_ns
            self._fullest_ns = max(self._fullest_ns, self._bucket_ns)
            self._bucket_ns = 0
            self._bucket_end_ns += BUCKET_NS
        if behind > BUCKETS + 1:
            self._bucket_end_ns += (behind - BUCKETS - 1) * BUCKET_NS
            self._past = [0] * BUCKETS
