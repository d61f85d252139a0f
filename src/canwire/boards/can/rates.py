"""At which rates CAN lines run, who has set them so, and which lines of one bus disagree."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from canwire.boards.can.modes import LineMode, LineStatus


class RunningLine(NamedTuple):
    """A line that takes part in a bus: `address` as people name it ("HW000001:0")."""

    address: str
    bus: str
    status: LineStatus

    def __str__(self) -> str:
        return f"{self.address} at {format_rates(self.status.mode)}, {format_setter(self.status)}"


class RateConflict(NamedTuple):
    """Lines of one bus that run at different rates, as copper allows it: they destroy each other's frames."""

    bus: str
    lines: tuple[RunningLine, ...]

    def __str__(self) -> str:
        return f"{self.bus}: different bit rates on one bus: {'; '.join(map(str, self.lines))}"


def rate_conflicts(lines: Iterable[RunningLine]) -> list[RateConflict]:
    """One for each bus whose lines disagree, in bit rate or, those that have one, in data bit rate."""
    buses: dict[str, list[RunningLine]] = {}
    for line in lines:
        if line.bus and line.status.running:
            buses.setdefault(line.bus, []).append(line)
    return [RateConflict(bus, tuple(found)) for bus, found in buses.items() if _disagree(found)]


def _disagree(lines: list[RunningLine]) -> bool:
    modes = [line.status.mode for line in lines if line.status.mode is not None]
    nominal = {mode.timing.bit_rate for mode in modes if mode.timing is not None}
    data = {rate for mode in modes if (rate := data_rate(mode)) is not None}
    return len(nominal) > 1 or len(data) > 1


def same_rates(now: LineMode, wanted: LineMode) -> bool:
    """Whether who runs at the rates of `now` finds them in `wanted`; one whose rate is still to be found is another."""
    if now.timing is None or wanted.timing is None:
        return False
    return now.timing.bit_rate == wanted.timing.bit_rate and data_rate(now) in (None, data_rate(wanted))


def format_rates(mode: LineMode | None) -> str:
    """`500000 bit/s`, with `, 2000000 after BRS` where there is such a phase."""
    if mode is None or mode.timing is None:
        return "no bit rate yet"
    data = data_rate(mode)
    return f"{mode.timing.bit_rate} bit/s" + ("" if data is None else f", {data} after BRS")


def format_setter(status: LineStatus) -> str:
    """`set by canwire dump (123)`"""
    if not status.set_by:
        return "set by nobody"
    return f"set by {status.set_by}" + (", which has left it" if status.set_by_left else "")


def data_rate(mode: LineMode) -> int | None:
    """After BRS, in bit/s; None for a line without."""
    return None if mode.data_timing is None else mode.data_timing.bit_rate
