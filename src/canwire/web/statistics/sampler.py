"""Samples the counters of every CAN line twice a second, and keeps them for ten minutes."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from canwire import CanwireError, LineStatus
from canwire.web.lines import can_lines

if TYPE_CHECKING:
    from canwire import Hub
    from canwire.web.lines import Line

LOOK_S = 0.5
KEPT = 1200  # looks: ten minutes


class Sample(NamedTuple):
    """One sample of a line: rates per second since the previous sample, and counters. `time_s` is the hub's time."""

    number: int
    time_s: float
    load: float
    sent: float
    received: float
    errors: float
    arbitration: float
    tec: int
    rec: int


class Sampler:
    """`hub()` returns the hub or raises HubLost. Samples in a separate thread until `close`."""

    def __init__(self, hub: Callable[[], Hub]) -> None:
        self._hub = hub
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._before: dict[str, LineStatus] = {}
        self._samples: dict[str, deque[Sample]] = {}
        self._peaks: dict[str, float] = {}
        self._number = 0
        self._thread = threading.Thread(target=self._run, name="sampler")
        self._thread.start()

    def samples(self, address: str, after: int) -> list[Sample]:
        """The samples of one line with a number above `after`, oldest first."""
        with self._lock:
            return [sample for sample in self._samples.get(address, ()) if sample.number > after]

    def peak(self, address: str) -> float:
        """Return the highest load of the line so far, in percent."""
        with self._lock:
            return self._peaks.get(address, 0.0)

    def look(self, lines: list[Line]) -> None:
        """Sample the present counters of these lines."""
        with self._lock:
            self._number += 1
            there = {line.place.address: line.can for line in lines if line.can is not None}
            for address, status in there.items():
                before = self._before.get(address)
                if before is not None and before.time_ns < status.time_ns:
                    self._keep(address, before, status)
            self._before = there

    def close(self) -> None:
        self._closing.set()
        self._thread.join()

    def _keep(self, address: str, before: LineStatus, now: LineStatus) -> None:
        seconds = (now.time_ns - before.time_ns) / 1e9

        def rate(name: str) -> float:
            """Return a rate; after a line was set up, counters restart at 0, and the rate uses the count since then."""
            after, earlier = int(getattr(now, name)), int(getattr(before, name))
            return round((after - earlier if after >= earlier else after) / seconds, 2)

        sample = Sample(
            self._number,
            now.time_ns / 1e9,
            round(now.load, 2),
            rate("frames_sent"),
            rate("frames_received"),
            rate("errors"),
            rate("arbitration_losses"),
            now.tec,
            now.rec,
        )
        self._samples.setdefault(address, deque(maxlen=KEPT)).append(sample)
        self._peaks[address] = max(self._peaks.get(address, 0.0), now.load)

    def _run(self) -> None:
        while not self._closing.wait(LOOK_S):
            try:
                lines = can_lines(self._hub())
            except CanwireError:  # the hub is away: the page's head says so
                lines = []
            self.look(lines)
