"""The VCI manual's search: worked by hand, refused with reasons, and checked against its conditions."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.errors import BadTiming
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.limits import BTR_OF_BIT_RATE
from tests.cases import each


@pytest.mark.conforms("X4-19")
def test_search_by_hand() -> None:
    # 8 MHz / 500 kbit/s: 16 quanta of 125 ns. 0.5 %: SJW >= 2*0.005*160 = 1.6; PROP = 300/125 up = 3;
    # 12 left, 6 and 6; condition 2: 2*0.005*(208 - 6) = 2.02, so SJW 3.
    found = BitTiming.search(500_000, 8_000_000, oscillator_tolerance=0.005, propagation_delay_ns=300)
    assert (found.prescaler, found.prop, found.phase1, found.tseg2, found.sjw) == (1, 3, 6, 6, 3)
    # an odd rest: PHASE1 gets the smaller half. 375 ns is 3 quanta exactly, 376 ns needs 4.
    for delay_ns, segments in ((375, (3, 6, 6)), (376, (4, 5, 6))):
        found = BitTiming.search(500_000, 8_000_000, 0.001, delay_ns)
        assert (found.prop, found.phase1, found.tseg2) == segments


@pytest.mark.conforms("X4-19")
@each(
    ("arguments", "why"),
    [
        (
            (500_000, 8_000_000, 0.01, 300),
            "sjw 5: SJA1000 takes 1..4 .condition 1 asks for 4, condition 2 for 5",
        ),
        ((500_000, 8_000_000, 0.02, 300), "PHASE1 6 is shorter than SJW 9"),
        ((1_000_000, 8_000_000, 0.012, 300), "PHASE1 2 is shorter than SJW 3"),
        ((1_000_000, 8_000_000, 0.012, 200), "no solution for 1000000 bit/s: PHASE1 2 is shorter than SJW 3"),
        ((1_000_000, 8_000_000, 0.005, 375), "PHASE2 2 is shorter than SJW 2 . IPT 1"),
        ((500_000, 8_000_000, 0.001, 1900), "PROP takes 16 of 16 quanta of 125 ns"),
        ((320_000, 8_000_000, 0.001, 100), "tseg2 12: SJA1000 takes 1..8"),
        ((700_000, 8_000_000, 0.001, 100), "nearest: 666667 and 727273"),
    ],
)
def test_search_says_why_there_is_no_solution(arguments: tuple[int, int, float, float], why: str) -> None:
    with pytest.raises(BadTiming, match=why):
        BitTiming.search(*arguments)


@pytest.mark.conforms("X4-19")
@given(st.sampled_from(sorted(BTR_OF_BIT_RATE)), st.floats(0, 0.02), st.floats(0, 1000))
def test_what_the_search_finds_meets_every_condition(bit_rate: int, off: float, delay_ns: float) -> None:
    try:
        found = BitTiming.search(bit_rate, 8_000_000, off, delay_ns)
    except BadTiming:
        return
    quantum_ns = found.prescaler * 125
    most = max(
        q for q in range(8, 26) if 8_000_000 % (bit_rate * q) == 0 and 8_000_000 // (bit_rate * q) <= 64
    )
    assert found.quanta == most
    assert (found.prop or 0) * quantum_ns >= delay_ns - 1e-6
    assert found.tseg2 - found.phase1 in (0, 1)
    assert found.phase1 >= found.sjw <= found.tseg2 - 1
    assert found.tolerance >= off - 1e-9
