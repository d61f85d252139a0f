"""LIN times by the tables of the reference."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.errors import BadValue
from canwire.values.lin.timing import (
    bit_rate_of,
    bit_time_of_sync,
    bit_time_ps,
    checked_rate,
    follows,
    longest_frame_ns,
    longest_header_ns,
    longest_response_bits,
    nominal_frame_ns,
    shortest_slot_ns,
    usual_slot_ns,
)
from tests.cases import each
from tests.tables import lin_vectors


@each("row", lin_vectors.FRAME_TIMES, ids=lambda row: f"N={row[0]}")
def test_frame_times(row: tuple[int, int, tuple[float, float]]) -> None:
    length, bits, *times = row
    for rate, (nominal, longest) in zip(lin_vectors.RATES, times, strict=True):
        assert nominal_frame_ns(rate, length) == round(bits * 1e9 / rate)
        assert nominal_frame_ns(rate, length) / 1e6 == pytest.approx(nominal, abs=0.00051)
        assert longest_frame_ns(rate, length) / 1e6 == pytest.approx(longest, abs=0.00051)


@pytest.mark.parametrize(("length", "nominal", "longest"), [(2, 26.667, 37.333), (8, 51.667, 72.333)])
def test_frame_times_at_2400(length: int, nominal: float, longest: float) -> None:
    assert nominal_frame_ns(2400, length) / 1e6 == pytest.approx(nominal, abs=0.0005)
    assert longest_frame_ns(2400, length) / 1e6 == pytest.approx(longest, abs=0.0005)


@each("row", lin_vectors.HEADER_TIMES, ids=lambda row: str(row[0]))
def test_header_times(row: tuple[float, ...]) -> None:
    rate, bit_us, nominal_ms, longest_ms, break_ms, five_us = row
    bit_ps = bit_time_ps(int(rate))
    assert bit_ps / 1e6 == pytest.approx(bit_us, abs=0.0005)
    assert 34 * bit_ps / 1e9 == pytest.approx(nominal_ms, abs=0.0005)
    assert longest_header_ns(int(rate)) / 1e6 == pytest.approx(longest_ms, abs=0.0005)
    assert 13 * bit_ps / 1e9 == pytest.approx(break_ms, abs=0.0005)
    assert 5 * bit_ps / 1e6 == pytest.approx(five_us, abs=0.05)


@pytest.mark.parametrize(("rate", "frames"), [(19200, (355, 300, 228, 154)), (20000, (370, 312, 238, 161))])
def test_frames_a_second(rate: int, frames: tuple[int, ...]) -> None:
    assert tuple(1_000_000_000 // nominal_frame_ns(rate, length) for length in (1, 2, 4, 8)) == frames


def test_time_out_of_an_absent_response() -> None:
    assert [longest_response_bits(length) for length in (1, 2, 4, 8)] == [28, 42, 70, 126]
    assert longest_response_bits(0) == 126  # unknown: as for 8


def test_slots() -> None:
    assert shortest_slot_ns(19200, 8) == 9_041_667
    assert shortest_slot_ns(19200, 8, jitter_ns=100_000) == 9_141_667
    assert usual_slot_ns(19200, 8) == 10_000_000  # two ticks of 5 ms
    assert usual_slot_ns(19200, 8, base_ns=10_000_000) == 10_000_000
    assert (usual_slot_ns(9600), usual_slot_ns(2400), usual_slot_ns(20000)) == (
        20_000_000,
        75_000_000,
        10_000_000,
    )


@each(("edges", "rate"), lin_vectors.SYNC_EDGES, ids=lambda value: str(value))
def test_bit_rates_of_sync_fields(edges: tuple[float, ...], rate: int) -> None:
    bit_ps = bit_time_of_sync([round(edge * 1e6) for edge in edges])
    assert bit_ps is not None
    assert bit_rate_of(bit_ps) == pytest.approx(rate, rel=1e-4)


@given(st.integers(1000, 20000), st.integers(0, 10**15))
def test_any_rate_is_found_by_its_sync_field(rate: int, start_ps: int) -> None:
    bit_ps = bit_time_ps(rate)
    assert bit_time_of_sync([start_ps + 2 * k * bit_ps for k in range(5)]) == bit_ps
    assert bit_rate_of(bit_ps) == rate


@each(
    "edges",
    [(0, 4, 6, 8, 10), (0, 2, 6, 8, 10), (0, 2, 4, 6), (0, 0, 0, 0, 0), (0, 2, 4, 6, 9)],
    ids=["0x54", "0x5D", "four", "none", "late"],
)
def test_what_is_no_sync_field(edges: tuple[int, ...]) -> None:
    assert bit_time_of_sync([edge * 52_083_333 for edge in edges]) is None


def test_a_slave_follows_within_14_percent_of_its_own_clock_and_half_a_percent_of_the_master_s() -> None:
    for own, master in ((1.14, 0.995), (0.86, 1.005)):
        assert follows(round(1e9 / own), round(1e9 / master))
    assert not follows(1_000_000, 1_146_001)
    assert not follows(1_000_000, 853_999)


def test_why_a_break_of_13_bits_is_enough() -> None:
    slow, fast = bit_time_ps(19200, -140_000), bit_time_ps(19200, 140_000)
    assert 13 * bit_time_ps(19200) / slow == pytest.approx(11.18, abs=0.005)
    assert 9 * bit_time_ps(19200) / fast == pytest.approx(10.26, abs=0.005)


@pytest.mark.conforms("X3-37")
@each("rate", [999, 20001, 0, -1, 19200.0, None])
def test_rates_that_lin_does_not_have(rate: int) -> None:
    with pytest.raises(BadValue, match="LIN runs at 1000 to 20000 bit/s"):
        checked_rate(rate)


@pytest.mark.conforms("X3-37")
def test_rates_that_lin_has() -> None:
    assert [checked_rate(rate) for rate in (1000, 2400, 9600, 10400, 19200, 20000)]
    assert checked_rate(0, auto=True) == 0
