"""The time in front of a line, as candump's -t shows it, and the bus's own."""

from __future__ import annotations

from datetime import datetime

KINDS = {
    "a": "absolute, seconds since 1970",
    "d": "since the line before",
    "z": "since the first line",
    "A": "absolute, as a date",
    "h": "the bus's own clock, in nanoseconds: seconds since its hub began",
}
ABSOLUTE = ("a", "A")


class Stamps:
    """One line after the other; `epoch_ns` is the wall clock when the hub's time was 0."""

    def __init__(self, kind: str, epoch_ns: int) -> None:
        self._kind = kind
        self._epoch_ns = epoch_ns
        self._from_ns: int | None = None

    def text(self, time_ns: int) -> str:
        """The text in parentheses before a line with this time of the hub."""
        if self._kind == "a":
            return f"({_decimal(time_ns + self._epoch_ns, 10)})"
        if self._kind == "A":
            return f"({_date(time_ns + self._epoch_ns)})"
        if self._kind == "h":
            return f"({time_ns // 1_000_000_000:06d}.{time_ns % 1_000_000_000:09d})"
        if self._from_ns is None:
            self._from_ns = time_ns
        since_ns = max(0, time_ns - self._from_ns)
        if self._kind == "d":
            self._from_ns = time_ns
        return f"({_decimal(since_ns, 3)})"


def _decimal(time_ns: int, digits: int) -> str:
    micros = time_ns // 1000
    return f"{micros // 1_000_000:0{digits}d}.{micros % 1_000_000:06d}"


def _date(time_ns: int) -> str:
    seconds, rest = divmod(time_ns, 1_000_000_000)
    return f"{datetime.fromtimestamp(seconds):%Y-%m-%d %H:%M:%S}.{rest // 1000:06d}"
