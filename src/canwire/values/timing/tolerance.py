"""How far an oscillator may be off: the conditions of a CAN bus (I, II) and a CAN FD bus (III to V).

Source: VCI V4 manual 5.2.3, conditions 1 and 2; Bosch CAN FD specification 1.0;
reference/can-protocol.md section 8.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Protocol

from canwire.errors import BadTiming


class Phases(Protocol):
    """What the conditions need of a bit timing: Phases's properties of the same names, lengths in quanta."""

    @property
    def clock_hz(self) -> int: ...
    @property
    def prescaler(self) -> int: ...
    @property
    def quanta(self) -> int: ...
    @property
    def phase1(self) -> int: ...
    @property
    def tseg2(self) -> int: ...
    @property
    def jump(self) -> int: ...


def condition_1(timing: Phases) -> Fraction:
    """2 dF * 10 bits <= SJW: stuffing leaves at most 10 bits between two edges."""
    return Fraction(timing.jump, 20 * timing.quanta)


def condition_2(timing: Phases) -> Fraction:
    """2 dF * (13 bits - PHASE2) <= min(PHASE1, PHASE2): error flags last up to 13 bits."""
    return Fraction(min(timing.phase1, timing.tseg2), 2 * (13 * timing.quanta - timing.tseg2))


def fd_conditions(nominal: Phases, data: Phases) -> dict[str, Fraction]:
    """All five, "I" to "V"; raises BadTiming if the two phases do not share a clock."""
    if data.clock_hz != nominal.clock_hz:
        raise BadTiming(
            f"nominal clock {nominal.clock_hz} Hz, data clock {data.clock_hz} Hz: not one controller"
        )
    return {
        "I": condition_1(nominal),
        "II": condition_2(nominal),
        "III": condition_1(data),
        **switching_conditions(nominal, data),
    }


def switching_conditions(nominal: Phases, data: Phases) -> dict[str, Fraction]:
    """Conditions "IV" and "V", of the rate switches back and forth; the quanta may come from different clocks."""
    ratio = Fraction(nominal.prescaler * data.clock_hz, data.prescaler * nominal.clock_hz)
    to_nominal = (6 * data.quanta - data.tseg2) / ratio + 7 * nominal.quanta
    to_data = (2 * nominal.quanta - nominal.tseg2) * ratio + data.tseg2 + 4 * data.quanta
    return {
        "IV": min(data.phase1, data.tseg2) / (2 * to_nominal),
        "V": (data.jump - (ratio - 1)) / (2 * to_data),
    }
