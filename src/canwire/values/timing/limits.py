"""The ranges of the timing registers of controllers, and the bit rates that they produce from a clock.

A bit is SYNC (1 quantum), then tseg1 = PROP + PHASE1, the sample point, then tseg2 = PHASE2.
One quantum lasts prescaler / clock_hz seconds.

Source: SJA1000 data sheet 6.5.1 and 6.5.2; VCI V4 manual 5.2.3;
reference/can-protocol.md section 8; reference/vci.md section 8.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache
from typing import ClassVar

from canwire.errors import BadTiming
from canwire.values.frozen import dataclass

BTR_OF_BIT_RATE = {
    5_000: (0x3F, 0x7F),
    10_000: (0x31, 0x1C),
    20_000: (0x18, 0x1C),
    50_000: (0x09, 0x1C),
    100_000: (0x04, 0x1C),
    125_000: (0x03, 0x1C),
    250_000: (0x01, 0x1C),
    500_000: (0x00, 0x1C),
    800_000: (0x00, 0x16),
    1_000_000: (0x00, 0x14),
}
"""bit/s -> (BTR0, BTR1) of an SJA1000 at 16 MHz: VCI's CAN_BT0_ and CAN_BT1_, CiA's rates and 5 kbit/s.

Source: VCI V4 manual 5.2.3, table of predefined constants.
"""


@dataclass(frozen=True, slots=True)
class TimingLimits:
    """The ranges of one controller's timing registers, in quanta; all bounds inclusive.

    `ipt` is the information processing time: the quanta after the sample point in which the
    controller cannot shorten PHASE2. A jump width that always works is at most
    min(PHASE1, PHASE2 - ipt).
    """

    name: str
    prescaler_max: int
    tseg1_max: int
    tseg2_max: int
    sjw_max: int
    quanta_min: int
    quanta_max: int
    prescaler_min: int = 1
    tseg1_min: int = 1
    tseg2_min: int = 1
    ipt: int = 0

    SJA1000: ClassVar[TimingLimits]
    FD_NOMINAL: ClassVar[TimingLimits]
    FD_DATA: ClassVar[TimingLimits]

    def check(self, prescaler: int, tseg1: int, tseg2: int, sjw: int) -> None:
        """Raise BadTiming that names the first value outside its register's range."""
        for name, value, low, high in (
            ("prescaler", prescaler, self.prescaler_min, self.prescaler_max),
            ("tseg1", tseg1, self.tseg1_min, self.tseg1_max),
            ("tseg2", tseg2, self.tseg2_min, self.tseg2_max),
            ("sjw", sjw, 1, self.sjw_max),
            ("quanta", 1 + tseg1 + tseg2, self.quanta_min, self.quanta_max),
        ):
            if not low <= value <= high:
                raise BadTiming(f"{name} {value}: {self.name} takes {low}..{high}")

    def widest_jump(self, phase1: int, phase2: int) -> int:
        """The largest SJW in quanta that these segments allow; 0 where even 1 is too much."""
        return max(0, min(self.sjw_max, phase1, phase2 - self.ipt))

    def tseg1_range(self, quanta: int) -> range:
        """All values of tseg1 that leave a legal tseg2 in a bit of this number of quanta; may be empty."""
        low = max(self.tseg1_min, quanta - 1 - self.tseg2_max)
        return range(low, min(self.tseg1_max, quanta - 1 - self.tseg2_min) + 1)


# The 8 quanta at least are Bosch's rule, not the chip's; 25 = 1 + 16 + 8.
SJA1000 = TimingLimits.SJA1000 = TimingLimits("SJA1000", 64, 16, 8, 4, 8, 25, ipt=1)
# Simulated figures of the ideal CAN FD controller, those of common 80 MHz controllers: rulings.md 11.
FD_NOMINAL = TimingLimits.FD_NOMINAL = TimingLimits("CAN FD nominal phase", 512, 256, 128, 128, 8, 385)
FD_DATA = TimingLimits.FD_DATA = TimingLimits("CAN FD data phase", 32, 32, 16, 16, 5, 49)


def checked_rate(name: str, hertz: int) -> int:
    """A positive whole number; raises BadTiming with its name otherwise."""
    if not isinstance(hertz, int) or hertz <= 0:
        example = ", such as 500_000 for 500 kbit/s" if name.endswith("bit_rate") else ""
        raise BadTiming(f"{name} {hertz!r}: a whole number above 0{example}")
    return hertz


def prescaler_for(bit_rate: int, clock_hz: int, quanta: int, limits: TimingLimits) -> int:
    """The prescaler that makes bit_rate with so many quanta per bit, or 0.

    A rate given in whole bit/s means the exact one that rounds or cuts to it: 33333 for
    33333 1/3. Beyond that it must be exact.
    """
    prescaler = _rounded(clock_hz, bit_rate * quanta)
    if not limits.prescaler_min <= prescaler <= limits.prescaler_max:
        return 0
    clocks = prescaler * quanta
    return prescaler if bit_rate in (clock_hz // clocks, _rounded(clock_hz, clocks)) else 0


def _rounded(value: int, by: int) -> int:
    """round(Fraction(value, by)) of numbers from 0 up: a search asks for hundreds while a program starts."""
    whole, rest = divmod(value, by)
    return whole + (2 * rest > by or (2 * rest == by and whole & 1))


def dividers(bit_rate: int, clock_hz: int, limits: TimingLimits) -> Iterator[tuple[int, int]]:
    """Every (prescaler, quanta per bit) that makes bit_rate, most quanta first."""
    checked_rate("bit_rate", bit_rate)
    checked_rate("clock_hz", clock_hz)
    for quanta in range(limits.quanta_max, limits.quanta_min - 1, -1):
        prescaler = prescaler_for(bit_rate, clock_hz, quanta, limits)
        if prescaler and limits.tseg1_range(quanta):
            yield prescaler, quanta


def choose(
    bit_rate: int, sample_point: Fraction, clock_hz: int, limits: TimingLimits, quanta_wanted: int = 0
) -> tuple[int, int, int]:
    """(prescaler, tseg1, tseg2) closest to the sample point (0..1).

    Among equals, quanta_wanted wins, then the finest quantum. Raises BadTiming with the
    nearest bit rates where the clock cannot make this one.
    """
    checked_rate("bit_rate", bit_rate)
    checked_rate("clock_hz", clock_hz)
    return _chosen(bit_rate, sample_point, clock_hz, limits, quanta_wanted)


@lru_cache(maxsize=1024)  # each line of a board calls this, and the search takes a millisecond
def _chosen(
    bit_rate: int, sample_point: Fraction, clock_hz: int, limits: TimingLimits, quanta_wanted: int
) -> tuple[int, int, int]:
    best: tuple[Fraction, bool, int] | None = None
    chosen = (0, 0, 0)
    for prescaler, quanta in dividers(bit_rate, clock_hz, limits):
        fitting = limits.tseg1_range(quanta)
        tseg1 = min(max(round(sample_point * quanta) - 1, fitting[0]), fitting[-1])
        rank = (abs(Fraction(1 + tseg1, quanta) - sample_point), quanta != quanta_wanted, -quanta)
        if best is None or rank < best:
            best, chosen = rank, (prescaler, tseg1, quanta - 1 - tseg1)
    if best is None:
        raise BadTiming(no_such_rate(bit_rate, clock_hz, limits))
    return chosen


def nearest_rates(bit_rate: int, clock_hz: int, limits: TimingLimits) -> list[int]:
    """The next lower and the next higher bit rate that the clock can make, rounded to bit/s."""
    longest = limits.prescaler_max * limits.quanta_max
    shortest = limits.prescaler_min * limits.quanta_min
    clocks = clock_hz // bit_rate
    lower = next((n for n in range(max(clocks, shortest), longest + 1) if _reachable(n, limits)), None)
    if lower is not None and lower * bit_rate == clock_hz:
        return [bit_rate]
    if lower is not None and lower * bit_rate < clock_hz:  # clocks was cut: that one is still too fast
        lower = next((n for n in range(lower + 1, longest + 1) if _reachable(n, limits)), None)
    higher = next((n for n in range(min(clocks, longest), shortest - 1, -1) if _reachable(n, limits)), None)
    return [round(Fraction(clock_hz, n)) for n in (lower, higher) if n is not None]


def _reachable(clocks: int, limits: TimingLimits) -> bool:
    """Whether a bit can last exactly this number of periods of the clock."""
    return any(
        clocks % quanta == 0 and limits.prescaler_min <= clocks // quanta <= limits.prescaler_max
        for quanta in range(limits.quanta_min, limits.quanta_max + 1)
    )


def no_such_rate(bit_rate: int, clock_hz: int, limits: TimingLimits) -> str:
    """The error text: why a clock cannot make this bit rate, and which rates it can make instead."""
    near = " and ".join(str(rate) for rate in nearest_rates(bit_rate, clock_hz, limits))
    return f"{bit_rate} bit/s cannot be made from {clock_hz} Hz ({limits.name}); nearest: {near} bit/s"


def usual_limits(bit_rate: int) -> TimingLimits:
    """The CAN FD controller's data phase above 1 Mbit/s, its nominal phase up to there."""
    return FD_DATA if checked_rate("bit_rate", bit_rate) > 1_000_000 else FD_NOMINAL


def usual_sample_point(bit_rate: int) -> Fraction:
    """CiA 301's 87.5 %, but 80 and 75 % at 800 and 1000 kbit/s, as in common register tables; FD data 80 %."""
    if 800_000 < bit_rate <= 1_000_000:
        return Fraction(3, 4)
    return Fraction(4, 5) if bit_rate > 500_000 else Fraction(7, 8)


def check_proportions(ts1: int, ts2: int, sjw: int, tdo: int) -> None:
    """Raise BadTiming if a field of CANBTP does not hold the value, or a segment is empty."""
    for name, value, least in (("ts1", ts1, 1), ("ts2", ts2, 1), ("sjw", sjw, 0), ("tdo", tdo, 0)):
        if not isinstance(value, int) or not least <= value <= 0xFFFF:
            raise BadTiming(f"{name} {value!r}: a proportion from {least} to 65535")


def check_data_rate(bit_rate: int, data_bit_rate: int) -> None:
    """Raise BadTiming for a data phase slower than the rest of the frame (source: ISO 11898-1, CAN FD)."""
    if data_bit_rate < bit_rate:
        raise BadTiming(
            f"data bit rate {data_bit_rate} bit/s: not below the bit rate, {bit_rate}; leave it out for classic CAN"
        )
