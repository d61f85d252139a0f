"""What a run on the bench came to: the numbers that `play` and `demo` end with."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from canwire import LabBus

_WIDTH = 14
_WINDOW_NS = 100_000_000  # of LabBus.peak_load


@dataclass(frozen=True, slots=True)
class Summary:
    """Loads are in percent of the time the bus could carry bits, times in seconds."""

    frames: int
    lost: int
    bus_load: float
    peak_load: float
    error_frames: int
    bus_time_s: float
    wall_time_s: float

    @classmethod
    def of(cls, bus: LabBus, *, frames: int, lost: int, bus_time_ns: int, wall_time_ns: int) -> Summary:
        """What `bus` says of itself, with what the recorder on it says: frames received, frames lost.

        The busiest 100 ms are no busier than the mean of a longer time, so a shorter one counts as 100 ms.
        """
        short = min(1.0, bus_time_ns / _WINDOW_NS)
        return cls(
            frames,
            lost,
            round(bus.mean_load * short, 3),
            round(bus.peak_load, 3),
            bus.error_frames,
            bus_time_ns / 1e9,
            wall_time_ns / 1e9,
        )

    @property
    def speed_factor(self) -> float:
        """How many times faster than the wall clock the bus ran."""
        return self.bus_time_s / self.wall_time_s if self.wall_time_s > 0 else 0.0

    def facts(self) -> dict[str, Any]:
        """The summary for --json."""
        return {**asdict(self), "speed_factor": round(self.speed_factor, 3)}

    def lines(self) -> list[str]:
        """The summary as text, one number on each line."""
        return [
            line("frames", str(self.frames)),
            line("lost", str(self.lost)),
            line("bus load", f"{self.bus_load:.2f} % mean, {self.peak_load:.2f} % in the busiest 100 ms"),
            line("error frames", str(self.error_frames)),
            line("bus time", f"{self.bus_time_s:.6f} s"),
            line("wall time", f"{self.wall_time_s:.3f} s"),
            line("speed", f"{self.speed_factor:.2f} times real time"),
        ]


def line(name: str, value: str) -> str:
    """One line of a summary."""
    return f"{name:<{_WIDTH}}{value}"
