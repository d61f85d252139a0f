"""The payloads of one ring that are in transit, and commands that wait to be sent. No I/O; times are arguments."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from canwire.hub.links.network.cuts.age import OtherClock
from canwire.hub.links.network.flow.way import Way

_MOMENT_NS = 20_000_000


class _Sent(NamedTuple):
    """A payload: the position after its records, its size in bytes, and when it was sent."""

    end: int
    size: int
    at_ns: int


class UnderWay:
    """The payloads that were sent and are not known to have arrived."""

    def __init__(self, way: Way) -> None:
        self._way = way
        self._sent: deque[_Sent] = deque()

    def add(self, end: int, size: int, now_ns: int) -> None:
        self._sent.append(_Sent(end, size, now_ns))
        self._way.sent(size)

    def came(self, received: int, now_ns: int) -> None:
        """All records up to that position arrived, at `now_ns` (0: unknown, not used to measure the network)."""
        last_ns, size, count = 0, 0, 0
        while self._sent and self._sent[0].end <= received:
            one = self._sent.popleft()
            last_ns, size, count = one.at_ns, size + one.size, count + 1
        if count:
            self._way.gone(size, count)
            if now_ns:
                self._way.came(last_ns, now_ns)

    def forget(self) -> None:
        """Forget all payloads: they are sent again, or not at all."""
        self._way.gone(sum(one.size for one in self._sent), len(self._sent))
        self._sent.clear()


class Given:
    """The times of commands that are not known to have arrived; commands of one moment are marked together."""

    def __init__(self, clock: OtherClock) -> None:
        self._clock = clock
        self._until: deque[tuple[int, int]] = deque()  # up to which position, and by when at the latest

    def mark(self, received: int, end: int, now_ns: int) -> None:
        """Commands up to `end` have been given by now; those up to `received` have arrived."""
        until = self._until
        while until and until[0][0] <= received:
            until.popleft()
        last, at_ns = until[-1] if until else (received, -_MOMENT_NS)
        if end > last and now_ns < at_ns + _MOMENT_NS:
            until[-1] = end, at_ns
        elif end > last:
            until.append((end, now_ns))

    def alike(self, sent: int) -> tuple[int, int]:
        """The number of commands after `sent` that were given at the same time, and their stamp; 0: no stamp needed."""
        for end, at_ns in self._until:
            if end > sent:
                return end - sent, self._clock.stamp(at_ns)
        return 0, 0
