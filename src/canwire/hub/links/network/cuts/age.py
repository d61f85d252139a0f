"""The age of a command on arrival: after a cut, or on a slow network, late commands must not be carried out.

A client stamps commands with its estimate of the hub's clock. A message always takes some time, so the largest observed
difference between the two clocks is the true one, except for the shortest transit time. A command counts as older
than it is by that time. Stamps are milliseconds in 24 bits; 0 means no stamp.
"""

from __future__ import annotations

_SPAN = 1 << 24  # ms, 4.6 hours: what is as old, or from the future, is a clock that jumped
_NS = 1_000_000
_DRIFT = 5_000  # of two clocks against each other: one part in so many


class OtherClock:
    """The clock of the other end, estimated from its messages. Times in ns are arguments; any thread may call."""

    def __init__(self) -> None:
        self._ahead_ns: int | None = None
        self._heard_ns = 0

    def heard(self, other_ns: int, now_ns: int) -> None:
        """A message of the other end: its time there when it was sent, and the time here when it arrived."""
        ahead_ns = other_ns - now_ns
        if self._ahead_ns is not None:
            ahead_ns = max(ahead_ns, self._ahead_ns - (now_ns - self._heard_ns) // _DRIFT)
        self._ahead_ns, self._heard_ns = ahead_ns, now_ns

    def stamp(self, now_ns: int) -> int:
        """The stamp of the present moment; 0 until the other end has sent its time."""
        return 0 if self._ahead_ns is None else (now_ns + self._ahead_ns) // _NS % _SPAN or 1


class Age:
    """The age limit for the commands of one client; `limit_s` 0: no limit."""

    def __init__(self, limit_s: float) -> None:
        self.limit_s = limit_s

    def over_s(self, stamp: int, now_ns: int) -> float:
        """The age in s of a command with this stamp; 0 if it is within the limit."""
        age_ms = (now_ns // _NS - stamp) % _SPAN
        if not stamp or not self.limit_s or age_ms >= _SPAN // 2:
            return 0.0
        return age_ms / 1000 if age_ms > self.limit_s * 1000 else 0.0
