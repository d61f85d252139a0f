"""How long a cable may be: the "Medium" table of the INduCAN104 manual."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.bus.medium import one_way_delay_ps
from canwire.errors import BadValue
from canwire.values.timing.bit_timing import BitTiming
from tests.cases import each

# bit rate, longest cable in metres
LONGEST = [(1_000_000, 25), (800_000, 50), (500_000, 100), (250_000, 250), (125_000, 500)]
CLOCK_HZ = 80_000_000
OPTO_COUPLER_NS = 75  # a 6N137, worth 15 m
OPTO_COUPLER_M = 15


def fits(timing: BitTiming, length_m: float, node_delay_ns: float = 0) -> bool:
    """Is a level there and back again by the sample point?"""
    return 2 * one_way_delay_ps(timing, length_m, node_delay_ns) <= timing.sample_time_ps


@pytest.mark.parametrize(("bit_rate", "length_m"), LONGEST)
class TestTable:
    def test_the_lab_samples_where_the_table_expects(self, bit_rate: int, length_m: int) -> None:
        usual = {1_000_000: 0.75, 800_000: 0.80}.get(bit_rate, 0.875)
        assert BitTiming.for_bit_rate(bit_rate, clock_hz=CLOCK_HZ).sample_point == usual

    def test_the_table_length_fits(self, bit_rate: int, length_m: int) -> None:
        assert fits(BitTiming.for_bit_rate(bit_rate, clock_hz=CLOCK_HZ), length_m)

    def test_one_metre_more_does_not(self, bit_rate: int, length_m: int) -> None:
        assert not fits(BitTiming.for_bit_rate(bit_rate, clock_hz=CLOCK_HZ), length_m + 1)

    def test_an_opto_coupler_at_either_end_is_worth_15_metres_each(
        self, bit_rate: int, length_m: int
    ) -> None:
        timing = BitTiming.for_bit_rate(bit_rate, clock_hz=CLOCK_HZ)
        both = 2 * OPTO_COUPLER_M
        if length_m > both:
            assert fits(timing, length_m - both, OPTO_COUPLER_NS)
            assert not fits(timing, length_m - both + 1, OPTO_COUPLER_NS)
        else:
            assert not fits(timing, 0, OPTO_COUPLER_NS)
        assert one_way_delay_ps(timing, 10, OPTO_COUPLER_NS) == one_way_delay_ps(timing, 10 + both, 0)


@each("wrong", [-1, -0.1, float("nan"), float("inf"), 1e300])
def test_a_cable_of_no_length_that_there_is(wrong: float) -> None:
    timing = BitTiming.for_bit_rate(500_000, clock_hz=CLOCK_HZ)
    with pytest.raises(BadValue, match=f"length_m {re.escape(str(wrong))}: from 0 to 10000"):
        one_way_delay_ps(timing, wrong, 0.0)
    with pytest.raises(BadValue, match=f"node_delay_ns {re.escape(str(wrong))}: from 0 to 100000"):
        one_way_delay_ps(timing, 0.0, wrong)


@each("bit_rate", [1_000_000, 125_000, 10_000])
def test_an_ideal_bus_has_no_delay(bit_rate: int) -> None:
    assert one_way_delay_ps(BitTiming.for_bit_rate(bit_rate, clock_hz=CLOCK_HZ), 0.0, 0.0) == 0


@given(
    st.sampled_from(
        [1_000_000, 800_000, 500_000, 250_000, 200_000, 125_000, 100_000, 50_000, 20_000, 10_000]
    ),
    st.floats(1, 5000),
    st.floats(0, 1000),
    st.floats(1, 100),
)
def test_more_is_later(bit_rate: int, length_m: float, node_delay_ns: float, more: float) -> None:
    timing = BitTiming.for_bit_rate(bit_rate, clock_hz=CLOCK_HZ)
    delay_ps = one_way_delay_ps(timing, length_m, node_delay_ns)
    assert delay_ps > length_m * 5000
    assert one_way_delay_ps(timing, length_m + more, node_delay_ns) > delay_ps
    assert one_way_delay_ps(timing, length_m, node_delay_ns + more) > delay_ps


def test_slower_buses_may_be_longer() -> None:
    longest = []
    for bit_rate in (1_000_000, 800_000, 500_000, 250_000, 125_000, 100_000, 50_000, 20_000, 10_000):
        timing = BitTiming.for_bit_rate(bit_rate, clock_hz=CLOCK_HZ)
        longest.append(max(length_m for length_m in range(0, 10_000, 5) if fits(timing, length_m)))
    assert longest == sorted(longest)
    assert longest[:5] == [length_m for _, length_m in LONGEST]
