"""Bit timing: quanta <-> bit/s, sample point, BTR0/BTR1, oscillator tolerance.

Source: SJA1000 data sheet 6.5.1 and 6.5.2; VCI V4 manual 5.2.3 and 7.3.4;
Bosch CAN FD specification 1.0; reference/can-protocol.md section 8.
"""

from __future__ import annotations

from fractions import Fraction

from canwire.errors import BadTiming
from canwire.values.frozen import dataclass
from canwire.values.mistakes.names import answers_wrong_names
from canwire.values.timing.limits import (
    FD_NOMINAL,
    SJA1000,
    TimingLimits,
    check_proportions,
    checked_rate,
    choose,
    dividers,
    no_such_rate,
    usual_limits,
    usual_sample_point,
)
from canwire.values.timing.search import search_segments
from canwire.values.timing.tolerance import condition_1, condition_2, fd_conditions

_LARGEST = {"prescaler": 1 << 16, "tseg1": 1 << 16, "tseg2": 1 << 16, "sjw": 1 << 16, "clock_hz": 10**10}


@answers_wrong_names
@dataclass(frozen=True, slots=True)
class BitTiming:
    """How one controller divides a bit, in quanta of prescaler / clock_hz seconds.

    The bit is SYNC (1), tseg1 (PROP + PHASE1), the sample point, tseg2 (PHASE2). `clock_hz` is
    the clock that the prescaler divides: half the oscillator on an SJA1000. `prop` says how much
    of tseg1 is PROP; left out, PHASE1 is as long as PHASE2 where tseg1 allows it. `tdo` is the
    offset of the transmitter delay compensation in periods of the clock, 0 for none (data phase
    only). Registers can hold an SJW that the segments cannot follow; such a timing exists too,
    and `jump` is what is left of it. Raises BadTiming, naming the value at fault.

    >>> BitTiming(1, 13, 2, 1, clock_hz=8_000_000).bit_rate
    500000
    """

    prescaler: int
    tseg1: int
    tseg2: int
    sjw: int
    clock_hz: int = 8_000_000
    prop: int | None = None
    triple_sampling: bool = False
    tdo: int = 0

    def __post_init__(self) -> None:
        for name, largest in _LARGEST.items():
            value = getattr(self, name)
            if not isinstance(value, int) or not 1 <= value <= largest:
                raise BadTiming(f"{name} {value!r}: a whole number from 1 to {largest}")
        if not isinstance(self.tdo, int) or not 0 <= self.tdo <= 0xFFFF:
            raise BadTiming(f"tdo {self.tdo!r}: periods of the clock from 0 to 65535")
        if self.prop is None:
            object.__setattr__(self, "prop", self.tseg1 - min(self.tseg2, self.tseg1 - 1))
        elif not isinstance(self.prop, int) or not 0 <= self.prop <= self.tseg1:
            raise BadTiming(f"prop {self.prop!r}: PROP is part of tseg1 {self.tseg1}")

    @property
    def quanta(self) -> int:
        """Quanta per bit, SYNC included."""
        return 1 + self.tseg1 + self.tseg2

    @property
    def phase1(self) -> int:
        """PHASE1 in quanta: tseg1 without PROP."""
        return self.tseg1 - (self.prop or 0)

    @property
    def jump(self) -> int:
        """The quanta that one resynchronisation can move: SJW, at most PHASE1 and PHASE2."""
        return min(self.sjw, self.phase1, self.tseg2)

    @property
    def exact_bit_rate(self) -> Fraction:
        """Bit/s without rounding."""
        return Fraction(self.clock_hz, self.prescaler * self.quanta)

    @property
    def bit_rate(self) -> int:
        """Bit/s, rounded to a whole number; `exact_bit_rate` is not."""
        return round(self.exact_bit_rate)

    @property
    def bit_time_ps(self) -> int:
        """Length of a bit in picoseconds, rounded."""
        return self._picoseconds(self.quanta)

    @property
    def sample_time_ps(self) -> int:
        """The time from the start of a bit to its sample point, in picoseconds, rounded."""
        return self._picoseconds(1 + self.tseg1)

    @property
    def quantum_ps(self) -> int:
        """Length of a quantum in picoseconds, rounded."""
        return self._picoseconds(1)

    @property
    def sample_point(self) -> float:
        """The sample point as a part of the bit, 0..1."""
        return (1 + self.tseg1) / self.quanta

    @property
    def condition_1(self) -> float:
        """Largest oscillator error (0.01 is 1 %) that a jump repairs after 10 bits without an edge."""
        return float(condition_1(self))

    @property
    def condition_2(self) -> float:
        """Largest oscillator error at which 13 bits after an error flag are still sampled right."""
        return float(condition_2(self))

    @property
    def tolerance(self) -> float:
        """Largest oscillator error of this timing that meets both conditions: 0.00625 is 0.625 %."""
        return min(self.condition_1, self.condition_2)

    def fd_tolerance(self, data: BitTiming) -> dict[str, float]:
        """The five conditions of a CAN FD bus, "I" to "V": this is the nominal phase, `data` the other.

        The bus bears the smallest of them; one below 0 can never hold. Condition IV takes the phase
        segments of the data phase, as the Bosch specification 1.0 prints it (reference section 8).
        Raises BadTiming if the phases do not share a clock.
        """
        return {name: float(value) for name, value in fd_conditions(self, data).items()}

    def to_btr(self) -> tuple[int, int]:
        """(BTR0, BTR1) as an SJA1000 takes them; raises BadTiming if a value does not fit its field.

        The oscillator is twice clock_hz; PROP and the delay offset have no place there.
        """
        for name, largest in (("prescaler", 64), ("tseg1", 16), ("tseg2", 8), ("sjw", 4)):
            value = getattr(self, name)
            if value > largest:
                raise BadTiming(f"{name} {value} does not fit BTR0/BTR1, which hold 1..{largest}")
        btr0 = self.sjw - 1 << 6 | self.prescaler - 1
        return btr0, self.triple_sampling << 7 | self.tseg2 - 1 << 4 | self.tseg1 - 1

    @classmethod
    def from_btr(cls, btr0: int, btr1: int, oscillator_hz: int = 16_000_000) -> BitTiming:
        """The timing in BTR0 and BTR1 (0..255 each) of an SJA1000 with that crystal.

        Source: SJA1000 data sheet 6.5.1, 6.5.2: one quantum is 2 * prescaler / oscillator_hz.
        """
        for name, value in (("BTR0", btr0), ("BTR1", btr1)):
            if not isinstance(value, int) or not 0 <= value <= 0xFF:
                raise BadTiming(f"{name} {value!r}: a register holds 0..255")
        if checked_rate("oscillator_hz", oscillator_hz) % 2:
            raise BadTiming(f"oscillator_hz {oscillator_hz}: half of it must be whole")
        return cls(
            prescaler=(btr0 & 0x3F) + 1,
            tseg1=(btr1 & 0xF) + 1,
            tseg2=(btr1 >> 4 & 7) + 1,
            sjw=(btr0 >> 6) + 1,
            clock_hz=oscillator_hz // 2,
            triple_sampling=bool(btr1 & 0x80),
        )

    @classmethod
    def raw(
        cls,
        prescaler: int,
        tseg1: int,
        tseg2: int,
        sjw: int,
        clock_hz: int,
        *,
        limits: TimingLimits = FD_NOMINAL,
        tdo: int = 0,
        triple_sampling: bool = False,
    ) -> BitTiming:
        """Register values, checked against the controller's limits (CANBTP with CAN_BTMODE_RAW)."""
        timing = cls(prescaler, tseg1, tseg2, sjw, clock_hz, None, triple_sampling, tdo)
        limits.check(prescaler, tseg1, tseg2, sjw)
        return timing

    @classmethod
    def from_proportions(
        cls,
        bit_rate: int,
        ts1: int,
        ts2: int,
        sjw: int,
        clock_hz: int,
        *,
        limits: TimingLimits | None = None,
        tdo: int = 0,
        triple_sampling: bool = False,
    ) -> BitTiming:
        """A bit rate with segments in relation to each other: CANBTP without CAN_BTMODE_RAW.

        ts1 includes SYNC, so the sample point is ts1 / (ts1 + ts2); ts1 + ts2 quanta are taken
        where the controller can, else as many as hit that point best. sjw and tdo are in the same
        unit, 0 sjw meaning one quantum. Raises BadTiming: values outside 0..65535, no such bit
        rate, or an sjw wider than the segments allow.
        Source: VCI V4 manual 5.2.3 and 7.3.4.
        """
        check_proportions(ts1, ts2, sjw, tdo)
        limits = limits or usual_limits(bit_rate)
        total = ts1 + ts2
        prescaler, tseg1, tseg2 = choose(bit_rate, Fraction(ts1, total), clock_hz, limits, total)
        quanta = 1 + tseg1 + tseg2
        jump = max(1, round(Fraction(sjw * quanta, total)))
        offset = round(Fraction(tdo * quanta * prescaler, total))
        timing = cls(prescaler, tseg1, tseg2, jump, clock_hz, None, triple_sampling, offset)
        widest = limits.widest_jump(timing.phase1, tseg2)
        if jump > max(1, widest):
            raise BadTiming(
                f"sjw {sjw} of {ts1} + {ts2}: at most {widest * total // quanta} is allowed there"
            )
        return timing

    @classmethod
    def for_bit_rate(
        cls,
        bit_rate: int,
        sample_point: float | None = None,
        *,
        clock_hz: int = 80_000_000,
        sjw: int | None = None,
        limits: TimingLimits | None = None,
    ) -> BitTiming:
        """The best timing: first by sample point, then by the finest quantum, then by the widest jump.

        bit_rate in bit/s; sample_point 0..1, by default CiA's (`usual_sample_point`). limits default
        to the CAN FD controller's nominal phase, above 1 Mbit/s to its data phase.
        Raises BadTiming with the nearest rates if the clock cannot make this one.
        """
        limits = limits or usual_limits(bit_rate)
        wanted = usual_sample_point(bit_rate) if sample_point is None else sample_point
        if not isinstance(wanted, (int, float, Fraction)) or not 0 < wanted < 1:
            raise BadTiming(f"sample_point {wanted!r}: a fraction of the bit between 0 and 1")
        exact = Fraction(wanted).limit_denominator(100_000)
        prescaler, tseg1, tseg2 = choose(bit_rate, exact, clock_hz, limits)
        return _with_jump(prescaler, tseg1, tseg2, sjw, clock_hz, limits)

    @classmethod
    def search(
        cls,
        bit_rate: int,
        clock_hz: int,
        oscillator_tolerance: float,
        propagation_delay_ns: float,
        limits: TimingLimits = SJA1000,
    ) -> BitTiming:
        """The VCI manual's search; see `timing_search.search_segments`. Raises BadTiming: no solution."""
        found = search_segments(bit_rate, clock_hz, oscillator_tolerance, propagation_delay_ns, limits)
        tseg1 = found.prop + found.phase1
        return cls(found.prescaler, tseg1, found.phase2, found.sjw, clock_hz=clock_hz, prop=found.prop)

    @classmethod
    def solutions(
        cls,
        bit_rate: int,
        clock_hz: int = 80_000_000,
        *,
        limits: TimingLimits | None = None,
        sample_point: float | None = None,
    ) -> list[BitTiming]:
        """Every timing that makes the rate, with its widest jump; BadTiming if there is none.

        With `sample_point` (0..1) the timings nearest to it come first; without it those with most quanta, of these the
        latest sample points.
        """
        limits = limits or usual_limits(bit_rate)
        found = [
            _with_jump(prescaler, tseg1, quanta - 1 - tseg1, None, clock_hz, limits)
            for prescaler, quanta in dividers(bit_rate, clock_hz, limits)
            for tseg1 in reversed(limits.tseg1_range(quanta))
        ]
        if not found:
            raise BadTiming(no_such_rate(bit_rate, clock_hz, limits))
        if sample_point is not None:
            found.sort(key=lambda timing: abs(timing.sample_point - sample_point))
        return found

    def _picoseconds(self, quanta: int) -> int:
        return round(Fraction(quanta * self.prescaler * 10**12, self.clock_hz))


def _with_jump(
    prescaler: int, tseg1: int, tseg2: int, sjw: int | None, clock_hz: int, limits: TimingLimits
) -> BitTiming:
    """The timing with its widest jump, or with this one if the segments and registers allow it."""
    widest = max(1, limits.widest_jump(min(tseg2, tseg1 - 1), tseg2))
    if sjw is not None and (not isinstance(sjw, int) or not 1 <= sjw <= widest):
        raise BadTiming(f"sjw {sjw!r}: segments {tseg1} + {tseg2} of {limits.name} allow 1..{widest}")
    return BitTiming(prescaler, tseg1, tseg2, sjw or widest, clock_hz=clock_hz)
