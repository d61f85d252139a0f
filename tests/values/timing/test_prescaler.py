"""The whole numbers of a search for prescalers are those that fractions give."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from canwire.values.timing.limits import TimingLimits, prescaler_for

WIDE = TimingLimits("a wide one", 1 << 20, 1 << 20, 1 << 20, 1 << 20, 1, 1 << 20)


@given(
    st.integers(1, 2_000_000) | st.sampled_from([33_333, 83_333, 500_000]),
    st.integers(1, 160_000_000) | st.sampled_from([8_000_000, 80_000_000]),
    st.integers(1, 400),
)
def test_like_fractions(bit_rate: int, clock_hz: int, quanta: int) -> None:
    prescaler = round(Fraction(clock_hz, bit_rate * quanta))
    exact = Fraction(clock_hz, prescaler * quanta) if prescaler else Fraction(0)
    fits = WIDE.prescaler_min <= prescaler <= WIDE.prescaler_max and bit_rate in (int(exact), round(exact))
    assert prescaler_for(bit_rate, clock_hz, quanta, WIDE) == (prescaler if fits else 0)
