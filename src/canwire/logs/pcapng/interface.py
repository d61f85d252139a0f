"""An interface of a capture."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Interface:
    """One interface: its channel in the log, its link type, and the unit of its time stamps."""

    channel: int
    link: int
    ticks_per_s: int
    offset_ns: int

    def time_ns(self, ticks: int) -> int:
        seconds, rest = divmod(ticks, self.ticks_per_s)
        return seconds * 10**9 + rest * 10**9 // self.ticks_per_s + self.offset_ns
