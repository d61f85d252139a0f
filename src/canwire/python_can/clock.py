"""Converts the hub's time to the computer's clock, and gives the error of that."""

from __future__ import annotations

import math
import threading
import time
from weakref import WeakValueDictionary

from canwire import Hub, HubLost

_TRIES = 5
_KEPT_S = 10.0  # the two clocks are compared again after that


class HubClock:
    """Add `epoch_ns` to the hub's time to get nanoseconds since 1970.

    The error is at most half of the quickest round trip to the hub. The clocks are compared again every few seconds;
    the result only changes by the part that is certainly wrong. If the hub's time does not follow the clock (fast,
    virtual), they are compared once, and `error_s` is infinite. In lockstep the time counts from 0, so that it is the
    same in each run.
    """

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self._due_s = 0.0
        self.epoch_ns, self._error_ns = self._compared()

    @property
    def error_s(self) -> float:
        return self._error_ns / 1e9 if self._hub.time == "real" else math.inf

    def refresh(self) -> None:
        """Compare the clocks again if that is due."""
        if self._hub.time != "real" or time.monotonic() < self._due_s:
            return
        try:
            epoch_ns, error_ns = self._compared()
        except HubLost:  # what has arrived before is still received
            return
        self.epoch_ns = min(max(self.epoch_ns, epoch_ns - error_ns), epoch_ns + error_ns)
        self._error_ns = error_ns + abs(self.epoch_ns - epoch_ns)

    def _compared(self) -> tuple[int, int]:
        if self._hub.time == "lockstep":
            return 0, 0
        found = []
        for _ in range(_TRIES):
            before_ns = time.time_ns()
            hub_ns = self._hub.now_ns()
            after_ns = time.time_ns()
            found.append(((before_ns + after_ns) // 2 - hub_ns, (after_ns - before_ns + 1) // 2))
        self._due_s = time.monotonic() + _KEPT_S
        return min(found, key=lambda pair: pair[1])


_CLOCKS: WeakValueDictionary[Hub, HubClock] = WeakValueDictionary()
_LOCK = threading.Lock()


def clock_of(hub: Hub) -> HubClock:
    """The clock that all users of this connection share, so that their times compare to the nanosecond."""
    with _LOCK:
        clock = _CLOCKS.get(hub)
        if clock is None:
            clock = _CLOCKS[hub] = HubClock(hub)
        return clock
