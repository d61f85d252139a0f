"""At which rates CAN lines run, who has set them so, and which lines of one bus could not work together on copper."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from canwire.boards.can.modes import LineMode, LineStatus
from canwire.values.controller_options import USUAL
from canwire.values.timing.agreement import timing_findings
from canwire.values.timing.check import NodeTiming, TimingCheck


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


class TimingConflict(NamedTuple):
    """Lines of one bus at the same rates, whose timings, oscillators or cable break a rule of ISO 11898-1."""

    bus: str
    lines: tuple[RunningLine, ...]
    check: TimingCheck

    def __str__(self) -> str:
        return f"{self.bus}: this could not work on copper: {self.check}"


Conflict = RateConflict | TimingConflict


def bus_conflicts(lines: Iterable[RunningLine]) -> list[Conflict]:
    """What could not work on copper, bus by bus: different rates, else each broken rule of the timings."""
    found: list[Conflict] = []
    for running in _by_bus(lines):
        conflicts = rate_conflicts(running)
        found += conflicts or _timing_conflicts(running)
    return found


def node_timing(name: str, mode: LineMode, drift_ppm: float = 0.0) -> NodeTiming | None:
    """What the rules need of a line that is set up so; None while its rate is still to be found."""
    if mode.timing is None:
        return None
    return NodeTiming(name, mode.timing, mode.data_timing, drift_ppm, options=mode.options or USUAL)


def _timing_conflicts(lines: list[RunningLine]) -> list[Conflict]:
    """Those of one bus."""
    nodes = [
        node
        for line in lines
        if line.status.mode is not None
        and (node := node_timing(line.address, line.status.mode, line.status.drift_ppm)) is not None
    ]
    delay_ps = max((line.status.delay_ps for line in lines), default=0)
    found: list[Conflict] = []
    for check in timing_findings(nodes, delay_ps):
        named = set(check.nodes)
        found.append(
            TimingConflict(lines[0].bus, tuple(line for line in lines if line.address in named), check)
        )
    return found


def _by_bus(lines: Iterable[RunningLine]) -> list[list[RunningLine]]:
    buses: dict[str, list[RunningLine]] = {}
    for line in lines:
        if line.bus and line.status.running:
            buses.setdefault(line.bus, []).append(line)
    return list(buses.values())


def rate_conflicts(lines: Iterable[RunningLine]) -> list[RateConflict]:
    """One for each bus whose lines disagree, in bit rate or, those that have one, in data bit rate."""
    return [RateConflict(found[0].bus, tuple(found)) for found in _by_bus(lines) if _disagree(found)]


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
