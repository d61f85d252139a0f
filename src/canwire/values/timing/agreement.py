"""Whether the nodes of a CAN bus, with their present settings, could communicate on a real bus.

Each rule gives a TimingCheck: a figure, its upper limit, and a remedy if it exceeds the limit.

- Rates and oscillators: two nodes drift apart by no more than conditions I to V let a receiver follow (tolerance.py).
- Sample points: the rate of a CAN FD frame switches at the sample point of BRS. Nodes that sample it at different times
  are that much out of step in the data phase, in which a receiver may not have sampled before the sender's bit begins,
  nor take a sample after it has ended. The same holds at the CRC delimiter, where the rate switches back.
- Cable: a level comes to the far end and its answer back before the sample point (ISO 11898-1, propagation segment).
- Loop delay: a sender reads its own bit back before it samples it, or at a second sample point that lies in that bit.

Source: ISO 11898-1:2015 chapter 11.3; Bosch CAN FD specification 1.0; reference/can-protocol.md section 8.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from itertools import product

from canwire.values.controller_options import DelayCompensation
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.check import NodeTiming, TimingCheck
from canwire.values.timing.tolerance import condition_1, condition_2, switching_conditions

_SHOWN = 3
_STANDARD = "ISO 11898-1"
_CONDITIONS = "ISO 11898-1, oscillator tolerance, condition {}"


def timing_checks(nodes: Iterable[NodeTiming], delay_ps: int = 0) -> list[TimingCheck]:
    """Every rule that applies to these nodes, each at its tightest place, the tightest rule first.

    `delay_ps` is the bus's, from one node's output to another's input: cable, transceivers and couplers.
    """
    groups = _alike(nodes)
    tightest: dict[str, TimingCheck] = {}
    for check in _every_check(groups, delay_ps):
        known = tightest.get(check.what)
        if known is None or (check.used, -check.limit) > (known.used, -known.limit):
            tightest[check.what] = check
    return sorted(tightest.values(), key=lambda check: -check.used)


def timing_findings(nodes: Iterable[NodeTiming], delay_ps: int = 0) -> list[TimingCheck]:
    """The rules that are broken: settings that could not work on a real bus."""
    return [check for check in timing_checks(nodes, delay_ps) if check.exceeded]


class _Group:
    """Nodes with the same settings; `one` represents them."""

    def __init__(self, one: NodeTiming) -> None:
        self.one = one
        self.names = [one.name]

    def __str__(self) -> str:
        more = len(self.names) - _SHOWN
        return ", ".join(self.names[:_SHOWN]) + (f" and {more} more" if more > 0 else "")


def _alike(nodes: Iterable[NodeTiming]) -> list[_Group]:
    groups: dict[tuple[object, ...], _Group] = {}
    for node in nodes:
        key = (node.nominal, node.data, node.ppm, node.within_ppm, node.options)
        if key in groups:
            groups[key].names.append(node.name)
        else:
            groups[key] = _Group(node)
    return list(groups.values())


def _every_check(groups: list[_Group], delay_ps: int) -> Iterator[TimingCheck]:
    for group in groups:
        yield from _loop_checks(group)
        if len(groups) > 1 or len(group.names) > 1:
            yield _cable_check(group, delay_ps)
    for sender, receiver in product(groups, groups):
        if sender is not receiver or len(sender.names) > 1:
            yield from _pair_checks(sender, receiver)


def _pair_checks(sender: _Group, receiver: _Group) -> Iterator[TimingCheck]:
    """The rules for `receiver` and `sender`; a broken rule on rates is the last one."""
    nominal = sender.one.nominal, receiver.one.nominal
    bound = min((condition_1(nominal[1]), "I"), (condition_2(nominal[1]), "II"))
    rates = _drift_check(sender, receiver, nominal, bound, "bit rate")
    yield rates
    if rates.exceeded or sender.one.data is None or receiver.one.data is None:
        return
    data = sender.one.data, receiver.one.data
    data_rates = _drift_check(sender, receiver, data, (condition_1(data[1]), "III"), "data bit rate")
    yield data_rates
    if data_rates.exceeded:
        return
    switching = switching_conditions(nominal[1], data[1])
    # vendors' own presets have V below 0; clocks that do not drift at all bear that, no others do
    bound = min((max(value, Fraction(0)), name) for name, value in switching.items())
    yield _drift_check(sender, receiver, nominal, bound, "bit rate")
    if sender is not receiver:
        yield from _switch_checks(sender, receiver, nominal, data)


def _drift_check(
    sender: _Group,
    receiver: _Group,
    timings: tuple[BitTiming, BitTiming],
    bound: tuple[Fraction, str],
    rate: str,
) -> TimingCheck:
    """Check how much two bit times differ, by their rates and oscillators."""
    one, other = timings
    df, condition = bound
    drift = _drift(sender.one, receiver.one, one, other)
    same = one.exact_bit_rate == other.exact_bit_rate
    pair = f"{sender} and {receiver}" if sender is not receiver else str(sender)
    if same:
        what, problem = "oscillators", f"the oscillators of {pair} drift apart"
        remedy = "a wider SJW, longer phase segments, or better oscillators"
        if not df:
            remedy = "a data SJW as long as one nominal time quantum, best the same prescaler in both phases"
    else:
        what = f"{rate}s"
        problem = f"{pair} have different {rate}s ({one.bit_rate} and {other.bit_rate} bit/s)"
        remedy = f"give both the same {rate}"
    source = _CONDITIONS.format(condition)
    return _check(what, (sender, receiver), problem, 100 * drift, 200 * float(df), "%", remedy, source)


def _drift(sender: NodeTiming, receiver: NodeTiming, one: BitTiming, other: BitTiming) -> float:
    """The difference of two bit times as a part of a bit time, in the worst case of both oscillators."""
    ratio = float(one.exact_bit_rate / other.exact_bit_rate) - 1
    known = abs(ratio + (sender.ppm - receiver.ppm) * 1e-6)
    return known + (sender.within_ppm + receiver.within_ppm) * 1e-6


def _switch_checks(
    sender: _Group,
    receiver: _Group,
    nominal: tuple[BitTiming, BitTiming],
    data: tuple[BitTiming, BitTiming],
) -> Iterator[TimingCheck]:
    """Check by how much the rate switches shift the receiver against the sender: into the data phase, and out of it."""
    one, other = sender.one, receiver.one
    strayed = 2 * nominal[1].bit_time_ps * _drift(one, other, *nominal)
    pair = f"{sender} ({one.sample_points}) and {receiver} ({other.sample_points})"
    both = "give both the same sample points"
    rate = f"the data rate ({data[0].bit_rate} bit/s)"
    into = _phase_error(nominal, data)
    limit = _reach_ps(data[1], into)
    problem = f"{pair} switch to {rate} at different times"
    yield _check(
        "sample points",
        (sender, receiver),
        problem,
        (abs(into) + strayed) / 1e3,
        limit / 1e3,
        "ns",
        both,
        _STANDARD,
    )
    back = _phase_error(data, nominal)
    limit = _reach_ps(nominal[1], back)
    problem = f"{pair} switch back from {rate} at different times"
    yield _check(
        "switching back", (sender, receiver), problem, abs(back) / 1e3, limit / 1e3, "ns", both, _STANDARD
    )


def _phase_error(before: tuple[BitTiming, BitTiming], after: tuple[BitTiming, BitTiming]) -> int:
    """By how many ps the sender's bit begins later than the receiver's, after a switch at their sample points."""
    sampled = before[0].sample_time_ps - before[1].sample_time_ps
    return sampled + _tail_ps(after[0]) - _tail_ps(after[1])


def _reach_ps(receiver: BitTiming, error_ps: int) -> int:
    """By how many ps the receiver's bits may be shifted: a late edge must come before it samples, an early one after
    its last sample. It sees edges with the resolution of a quantum.
    """
    reach = receiver.sample_time_ps if error_ps >= 0 else _tail_ps(receiver)
    return reach - receiver.quantum_ps


def _tail_ps(timing: BitTiming) -> int:
    """The time from the sample point to the end of the bit, in ps."""
    return timing.bit_time_ps - timing.sample_time_ps


def _cable_check(group: _Group, delay_ps: int) -> TimingCheck:
    timing = group.one.nominal
    sample_ns = timing.sample_time_ps / 1e3
    problem = f"{group}: the sample point ({sample_ns:.4g} ns) comes before a level has been at the far end and back"
    remedy = "a shorter cable, a later sample point, or a lower bit rate"
    source = f"{_STANDARD}, propagation segment"
    return _check("cable", (group,), problem, 2 * delay_ps / 1e3, sample_ns, "ns", remedy, source)


def _loop_checks(group: _Group) -> Iterator[TimingCheck]:
    """Whether the node reads its own bits back in time, in both phases."""
    node = group.one
    loop_ns = node.options.loop_delay_ns
    if not loop_ns:
        return
    problem = f"{group} reads its own bits back after {loop_ns:g} ns"
    sample_ns = node.nominal.sample_time_ps / 1e3
    source = f"{_STANDARD}, propagation segment"
    yield _check(
        "loop delay",
        (group,),
        problem,
        loop_ns,
        sample_ns,
        "ns",
        "a faster transceiver or a lower rate",
        source,
    )
    if node.data is not None:
        yield _data_loop_check(group, node.data, loop_ns)


def _data_loop_check(group: _Group, data: BitTiming, loop_ns: float) -> TimingCheck:
    compensation = _compensation(group.one, data)
    rate = f"at {data.bit_rate} bit/s {group}"
    sample_ns, bit_ns = data.sample_time_ps / 1e3, data.bit_time_ps / 1e3
    source = f"{_STANDARD}, transmitter delay compensation"
    problem, remedy = f"{rate} reads its own bits back after its sample point", "switch delay compensation on"
    figure, limit = loop_ns, sample_ns
    if compensation is not None:
        second_ns = sample_ns if compensation.offset_ns is None else compensation.offset_ns
        if compensation.measured:
            second_ns = max(second_ns + loop_ns, compensation.filter_ns)
        remedy = f"set the offset of the delay compensation to the sample point, {sample_ns:.4g} ns"
        problem, limit = f"{rate} looks at its own bits before they have come back", second_ns
        if second_ns >= loop_ns:
            problem = f"{rate} looks at its own bits after they have ended"
            figure, limit = second_ns - loop_ns, bit_ns
    return _check("delay compensation", (group,), problem, figure, limit, "ns", remedy, source)


def _compensation(node: NodeTiming, data: BitTiming) -> DelayCompensation | None:
    if node.options.compensation is None and data.tdo:
        return DelayCompensation(1e9 * data.tdo / data.clock_hz)
    return node.options.compensation


def _check(
    what: str,
    groups: tuple[_Group, ...],
    problem: str,
    figure: float,
    limit: float,
    unit: str,
    remedy: str,
    source: str,
) -> TimingCheck:
    names = dict.fromkeys(name for group in groups for name in group.names)
    return TimingCheck(what, tuple(names), problem, figure, limit, unit, remedy, source)
