"""The VCI manual's way from bit rate, oscillator tolerance and cable delay to segments.

Source: VCI V4 manual 5.2.3, "Modus CAN_BTMODE_RAW"; its conditions 1 and 2.
"""

from __future__ import annotations

from fractions import Fraction
from math import ceil
from typing import NamedTuple

from canwire.errors import BadTiming
from canwire.values.timing.limits import TimingLimits, checked_rate, dividers, no_such_rate


class Segments(NamedTuple):
    """The segments of one bit in quanta, and the prescaler that makes the quantum."""

    prescaler: int
    prop: int
    phase1: int
    phase2: int
    sjw: int


def search_segments(
    bit_rate: int,
    clock_hz: int,
    oscillator_tolerance: float,
    propagation_delay_ns: float,
    limits: TimingLimits,
) -> Segments:
    """Search as the manual describes; raises BadTiming that says which condition failed.

    The bit rate in bit/s; the tolerance as a fraction (0.001 is 0.1 %) of the worst oscillator on
    the bus; the delay of cable and transceivers, there and back, in nanoseconds. As many quanta as
    possible, one less until the prescaler is whole; Q_PROP rounded up; the smaller half of the
    rest is PHASE1, the larger PHASE2; Q_SJW the least that meets conditions 1 and 2;
    then PHASE1 >= SJW and PHASE2 >= SJW + IPT, or there is no solution.
    """
    tolerance = _fraction("oscillator_tolerance", oscillator_tolerance, 1)
    delay_ns = _fraction("propagation_delay_ns", propagation_delay_ns, 1_000_000_000)
    found = next(dividers(bit_rate, checked_rate("clock_hz", clock_hz), limits), None)
    if found is None:
        raise BadTiming(no_such_rate(bit_rate, clock_hz, limits))
    prescaler, quanta = found
    prop = ceil(delay_ns * clock_hz / (prescaler * 1_000_000_000))
    phase = quanta - 1 - prop
    if phase < 2:
        raise BadTiming(
            f"no solution for {bit_rate} bit/s: PROP takes {prop} of {quanta} quanta of "
            f"{prescaler * 1e9 / clock_hz:g} ns for a delay of {propagation_delay_ns} ns, which leaves "
            f"{max(phase, 0)} for PHASE1 and PHASE2"
        )
    phase1, phase2 = phase // 2, phase - phase // 2
    jump_1 = ceil(20 * tolerance * quanta)
    jump_2 = ceil(2 * tolerance * (13 * quanta - phase2))
    segments = Segments(prescaler, prop, phase1, phase2, max(1, jump_1, jump_2))
    _check(segments, bit_rate, limits, f"condition 1 asks for {jump_1}, condition 2 for {jump_2}")
    return segments


def _fraction(name: str, value: float, limit: int) -> Fraction:
    """The value as the exact decimal that was meant, 0 up to below the limit."""
    if not isinstance(value, (int, float, Fraction)) or not 0 <= value < limit:  # NaN fails here too
        raise BadTiming(f"{name} {value!r}: a number from 0 to below {limit}")
    # 0.00625 as a float lies a little above the decimal; ceil() would then ask for one quantum more
    return Fraction(value).limit_denominator(1_000_000_000)


def _check(found: Segments, bit_rate: int, limits: TimingLimits, why: str) -> None:
    """Raise BadTiming if the phases are too short for the jump, or a segment leaves its register."""
    try:
        if found.phase1 < found.sjw:
            raise BadTiming(f"PHASE1 {found.phase1} is shorter than SJW {found.sjw}")
        if found.phase2 < found.sjw + limits.ipt:
            raise BadTiming(f"PHASE2 {found.phase2} is shorter than SJW {found.sjw} + IPT {limits.ipt}")
        limits.check(found.prescaler, found.prop + found.phase1, found.phase2, found.sjw)
    except BadTiming as error:
        raise BadTiming(f"no solution for {bit_rate} bit/s: {error} ({why} quanta of SJW)") from None
