"""How busy buses are: what their lines' counters say, look after look."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from canwire import LinePlace, LineStatus, format_rates

Now = list[tuple[LinePlace, LineStatus]]


class Reading(NamedTuple):
    """One bus: loads in percent, of the last second, the highest and the mean of all looks; rates a second.

    The first look is what the others count from: `frames` and `errors` are sums since then. `rates` is at which bit
    rates the bus's lines run.
    """

    bus: str
    load: float
    peak: float
    mean: float
    frames_s: float
    errors_s: float
    frames: int
    errors: int
    rates: str


class Meter:
    """Frames are counted by the line of a bus that saw most of them: lines that do not run see none."""

    def __init__(self) -> None:
        self._before: dict[str, LineStatus] = {}
        self._first = True
        self._loads: dict[str, list[float]] = {}  # how many, their sum, the highest
        self._sums: dict[str, list[int]] = {}

    def look(self, now: Now) -> list[Reading]:
        """One reading of each bus, in the order of the lines."""
        buses: dict[str, Now] = {}
        for place, status in now:
            buses.setdefault(place.info.bus or place.address, []).append((place, status))
        found = [self._reading(bus, lines) for bus, lines in buses.items()]
        self._before = {place.address: status for place, status in now}
        self._first = False
        return found

    def _reading(self, bus: str, lines: Now) -> Reading:
        news = [self._news(place, status) for place, status in lines]
        frames, errors = max(one[0] for one in news), max(one[1] for one in news)
        span_s = max(one[2] for one in news)
        load = max(status.load for _, status in lines)
        loads = self._loads.setdefault(bus, [0.0, 0.0, 0.0])
        if not self._first:
            loads[:] = loads[0] + 1, loads[1] + load, max(loads[2], load)
        sums = self._sums.setdefault(bus, [0, 0])
        sums[:] = sums[0] + frames, sums[1] + errors
        return Reading(
            bus,
            load,
            loads[2],
            loads[1] / (loads[0] or 1),
            frames / span_s if span_s else 0.0,
            errors / span_s if span_s else 0.0,
            sums[0],
            sums[1],
            _rates([status for _, status in lines]),
        )

    def _news(self, place: LinePlace, status: LineStatus) -> tuple[int, int, float]:
        """Frames and errors since the look before, and how long ago that was, in seconds."""
        before = self._before.get(place.address)
        if before is None or status.time_ns <= before.time_ns:
            return 0, 0, 0.0
        frames = _since(
            before.frames_sent + before.frames_received, status.frames_sent + status.frames_received
        )
        return frames, _since(before.errors, status.errors), (status.time_ns - before.time_ns) / 1e9


def _since(before: int, now: int) -> int:
    """Counters restart when a line is set up."""
    return now - before if now >= before else now


def _rates(statuses: Sequence[LineStatus]) -> str:
    found = dict.fromkeys(format_rates(status.mode) for status in statuses if status.running)
    return " and ".join(found) or "nobody is there"
