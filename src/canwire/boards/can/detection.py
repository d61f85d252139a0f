"""Finds the bit rate of a running bus: a separate listen-only node tries one candidate after the other.

Source: VCI V4 manual 5.2.3 and 6.6.3, DetectBaud; it sends nothing and disturbs no frame.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from canwire.boards.can.channel import Channel
from canwire.boards.catalogue import listener, unplug
from canwire.bus.can.node import Bus
from canwire.drivers.driver import LineSettings
from canwire.errors import BadValue, CanwireError, NothingHeard
from canwire.timeline import Timeline, Timer
from canwire.values.event import EventKind
from canwire.values.timing.bit_timing import BitTiming

_QUEUE = 64


class Detection:
    """One search; `done` is called once, with the index of the rate or with NothingHeard.

    A candidate is right when a whole frame comes, wrong at the first error. Each gets `timeout_ms` of bus time;
    if the bus stays silent for all of them, the result is NothingHeard.
    """

    def __init__(
        self,
        name: str,
        bus: Bus,
        timeline: Timeline,
        candidates: Sequence[tuple[BitTiming, BitTiming | None]],
        timeout_ms: int,
        iso_fd: bool,
        done: Callable[[int | CanwireError], None],
    ) -> None:
        if not candidates:
            raise BadValue(f"{name}: no bit rates to try")
        self._timeline = timeline
        self._name = name
        self._candidates = candidates
        self._timeout_ns = timeout_ms * 1_000_000
        self._iso_fd = iso_fd
        self._done = done
        self._line = listener(f"{name} (listening)", bus, timeline)
        self._heard = Channel(_QUEUE, 0, events=frozenset({EventKind.ERROR}))
        self._timer: Timer | None = None
        self._at = -1
        self._over = False

    def begin(self) -> None:
        self._line.open(self._heard)
        self._heard.receive.listener = self._listen
        self._next()

    def cancel(self, why: CanwireError | None = None) -> None:
        """End the search; `done` is called with the error `why`, by default NothingHeard."""
        self._finish(why or NothingHeard(f"{self._name}: the search for a bit rate was ended"))

    def _next(self) -> None:
        """Try the next candidate, or end the search if there is none."""
        self._at += 1
        self._quiet()
        if self._at >= len(self._candidates):
            tried = ", ".join(dict.fromkeys(str(timing.bit_rate) for timing, _ in self._candidates))
            self._finish(NothingHeard(f"{self._name}: no frame at any of these bit rates: {tried}"))
            return
        nominal, data = self._candidates[self._at]
        driver = self._line.driver
        now_ns = self._timeline.now_ns
        driver.configure(LineSettings(nominal, data, self._iso_fd, listen_only=True))
        self._line.controller.timing = None  # a trial only: no reason for a warning
        driver.start(now_ns)
        self._timer = self._timeline.at(now_ns + self._timeout_ns, self._next)

    def _listen(self) -> None:
        """Schedule `_look` for a record that came while the bus was working; it runs when that work is done."""
        self._timeline.at(self._timeline.now_ns, self._look)

    def _look(self) -> None:
        record = self._heard.receive.take_bytes()
        self._heard.receive.clear()
        if record is None or self._over:
            return
        if record[12] == EventKind.ERROR:
            self._next()
        else:
            self._finish(self._at)

    def _quiet(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._line.driver.stop(self._timeline.now_ns)
        self._heard.receive.clear()

    def _finish(self, result: int | CanwireError) -> None:
        if not self._over:
            self._over = True
            self._quiet()
            self._heard.receive.listener = None
            unplug(self._line)
            self._done(result)
