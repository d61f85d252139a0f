"""The conditions of an oscillator, by hand and by trial."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.errors import BadTiming
from canwire.values.timing.bit_timing import BitTiming


@pytest.mark.conforms("G-13")
def test_conditions_give_the_known_tolerances() -> None:
    widest = BitTiming(1, tseg1=5, tseg2=4, sjw=4, prop=1)
    assert widest.condition_1 == 0.02
    assert round(widest.condition_2, 5) == 0.01587
    assert widest.tolerance == widest.condition_2
    assert BitTiming.from_btr(0x00, 0x14).tolerance == 0.00625


@pytest.mark.conforms("G-13")
@given(st.integers(1, 16), st.integers(1, 8), st.integers(1, 4))
def test_conditions_hold_at_the_tolerance_and_not_beyond(tseg1: int, tseg2: int, sjw: int) -> None:
    timing = BitTiming(1, tseg1, tseg2, sjw)
    bit = timing.quanta
    phases = min(timing.phase1, tseg2)

    def both_hold(off: float) -> bool:
        return 2 * off * 10 * bit <= min(sjw, phases) and 2 * off * (13 * bit - tseg2) <= phases

    assert both_hold(timing.tolerance * 0.999999)
    assert not both_hold(timing.tolerance * 1.000001 + 1e-12)


@pytest.mark.conforms("PL-06")
def test_fd_conditions_by_hand() -> None:
    nominal = BitTiming(2, 63, 16, 16, clock_hz=80_000_000)
    data = BitTiming(1, 14, 5, 5, clock_hz=80_000_000)

    found = nominal.fd_tolerance(data)

    assert found["I"] == 16 / (20 * 80)
    assert found["II"] == pytest.approx(16 / (2 * (13 * 80 - 16)))
    assert found["III"] == 5 / (20 * 20)
    assert found["IV"] == pytest.approx(5 / (2 * ((6 * 20 - 5) / 2 + 7 * 80)))
    assert found["V"] == pytest.approx((5 - 1) / (2 * ((2 * 80 - 16) * 2 + 5 + 4 * 20)))
    with pytest.raises(BadTiming, match="40000000"):
        nominal.fd_tolerance(BitTiming(1, 14, 5, 5, clock_hz=40_000_000))
