"""The rates of CAN lines, the programs that set them, and lines of one bus that could not work together on copper."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from canwire.boards.can.modes import LineMode, LineStatus
from canwire.values.controller_options import USUAL
from canwire.values.timing.agreement import timing_findings
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.check import NodeTiming, TimingCheck


class RunningLine(NamedTuple):
    """A line that takes part in a bus; `address` is its name for users ("HW000001:0")."""

    address: str
    bus: str
    status: LineStatus

    def __str__(self) -> str:
        setter = format_setter(self.status)
        if self.status.chip_timing is not None:
            return f"{self.address} at {self.status.chip_timing.bit_rate} bit/s by its chip's registers, {setter}"
        return f"{self.address} at {format_rates(self.status.mode)}, {setter}"


class RateConflict(NamedTuple):
    """Lines of one bus that run at different rates, so they destroy each other's frames.

    `others` are nodes that are no lines, such as chips attached to the bus, if their rates differ.
    """

    bus: str
    lines: tuple[RunningLine, ...]
    others: tuple[NodeTiming, ...] = ()

    def __str__(self) -> str:
        nodes = [*map(str, self.lines), *(f"{node.name} at {_node_rates(node)}" for node in self.others)]
        return f"{self.bus}: different bit rates on one bus: {'; '.join(nodes)}"


class TimingConflict(NamedTuple):
    """Lines of one bus at the same rates, whose timings, oscillators or cable break a rule of ISO 11898-1."""

    bus: str
    lines: tuple[RunningLine, ...]
    check: TimingCheck

    def __str__(self) -> str:
        return f"{self.bus}: this could not work on copper: {self.check}"


Conflict = RateConflict | TimingConflict


def bus_conflicts(lines: Iterable[RunningLine]) -> list[Conflict]:
    """What could not work on copper, bus by bus: different rates, or else each broken rule of the timings."""
    found: list[Conflict] = []
    for running in _by_bus(lines):
        conflicts = rate_conflicts(running)
        found += conflicts or _timing_conflicts(running)
    return found


def node_timing(name: str, status: LineStatus) -> NodeTiming | None:
    """The data of a line for the timing rules; None for a line that is not set up, or whose rate is not yet found."""
    mode, timing = status.mode, _timing(status)
    if mode is None or timing is None:
        return None
    return NodeTiming(name, timing, mode.data_timing, status.drift_ppm, options=mode.options or USUAL)


def _timing(status: LineStatus) -> BitTiming | None:
    """The timing in the registers of its chip, if a program wrote one there; else that of the line's mode."""
    return status.chip_timing or (None if status.mode is None else status.mode.timing)


def _timing_conflicts(lines: list[RunningLine]) -> list[Conflict]:
    """The broken timing rules of one bus."""
    found_nodes = (node_timing(line.address, line.status) for line in lines)
    nodes = [node for node in found_nodes if node is not None]
    nodes += _neighbours(lines)
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
    """One conflict for each bus whose nodes have different bit rates, or different data bit rates."""
    return [
        RateConflict(found[0].bus, tuple(found), _others_at_other_rates(found))
        for found in _by_bus(lines)
        if _disagree(found)
    ]


def _disagree(lines: list[RunningLine]) -> bool:
    others = _neighbours(lines)
    nominal = _nominal_rates(lines) | {node.nominal.bit_rate for node in others}
    data = _data_rates(lines) | {node.data.bit_rate for node in others if node.data is not None}
    return len(nominal) > 1 or len(data) > 1


def _neighbours(lines: list[RunningLine]) -> tuple[NodeTiming, ...]:
    """The other nodes of one bus, which all its lines report alike."""
    return lines[0].status.neighbours if lines else ()


def _others_at_other_rates(lines: list[RunningLine]) -> tuple[NodeTiming, ...]:
    """Those of the neighbours whose rates differ from the rates of a line; other neighbours are left out."""
    nominal, data = _nominal_rates(lines), _data_rates(lines)
    return tuple(
        node
        for node in _neighbours(lines)
        if nominal - {node.nominal.bit_rate} or (node.data is not None and data - {node.data.bit_rate})
    )


def _nominal_rates(lines: list[RunningLine]) -> set[int]:
    return {timing.bit_rate for line in lines if (timing := _timing(line.status)) is not None}


def _data_rates(lines: list[RunningLine]) -> set[int]:
    modes = (line.status.mode for line in lines)
    return {rate for mode in modes if mode is not None and (rate := data_rate(mode)) is not None}


def same_rates(now: LineMode, wanted: LineMode) -> bool:
    """Whether the rates of `now` are also those of `wanted`; False if one of them has still to be found."""
    if now.timing is None or wanted.timing is None:
        return False
    return now.timing.bit_rate == wanted.timing.bit_rate and data_rate(now) in (None, data_rate(wanted))


def format_rates(mode: LineMode | None) -> str:
    """`500000 bit/s`, with `, 2000000 after BRS` if there is a data rate."""
    if mode is None or mode.timing is None:
        return "no bit rate yet"
    return _rates(mode.timing.bit_rate, data_rate(mode))


def _node_rates(node: NodeTiming) -> str:
    return _rates(node.nominal.bit_rate, None if node.data is None else node.data.bit_rate)


def _rates(nominal: int, data: int | None) -> str:
    return f"{nominal} bit/s" + ("" if data is None else f", {data} after BRS")


def format_setter(status: LineStatus) -> str:
    """The program that set the line up: `set by canwire dump (123)`."""
    if not status.set_by:
        return "set by nobody"
    return f"set by {status.set_by}" + (", which has left it" if status.set_by_left else "")


def data_rate(mode: LineMode) -> int | None:
    """The bit rate after BRS, in bit/s; None for a line without a data rate."""
    return None if mode.data_timing is None else mode.data_timing.bit_rate
