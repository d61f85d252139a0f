"""Bit timing against the tables of the documents, python-can, and slow obvious arithmetic."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.errors import BadTiming
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.limits import BTR_OF_BIT_RATE, FD_DATA, FD_NOMINAL, SJA1000, TimingLimits
from tests.cases import each

# reference/can-protocol.md section 8 (the VCI V4 manual table, CiA, LAWICEL S0-S8): BTR0, BTR1, bit/s,
# quantum in ps, quanta, sample point in tenths of a per cent
SJA1000_TABLE = [
    (0x00, 0x14, 1_000_000, 125_000, 8, 750),
    (0x00, 0x16, 800_000, 125_000, 10, 800),
    (0x00, 0x1C, 500_000, 125_000, 16, 875),
    (0x01, 0x1C, 250_000, 250_000, 16, 875),
    (0x03, 0x1C, 125_000, 500_000, 16, 875),
    (0x04, 0x1C, 100_000, 625_000, 16, 875),
    (0x09, 0x1C, 50_000, 1_250_000, 16, 875),
    (0x18, 0x1C, 20_000, 3_125_000, 16, 875),
    (0x31, 0x1C, 10_000, 6_250_000, 16, 875),
    (0x3F, 0x7F, 5_000, 8_000_000, 25, 680),
    (0x05, 0x1C, 83_333, 750_000, 16, 875),
    (0x07, 0x1C, 62_500, 1_000_000, 16, 875),
    (0x0E, 0x1C, 33_333, 1_875_000, 16, 875),
    (0x05, 0x1A, 95_238, 750_000, 14, 857),
    (0x0B, 0x1A, 47_619, 1_500_000, 14, 857),
    (0x00, 0x18, 666_667, 125_000, 12, 833),
    (0x00, 0x05, 1_000_000, 125_000, 8, 875),
    (0x81, 0x49, 250_000, 250_000, 16, 688),  # the INduCAN104 manual
]

# reference/vci.md section 3: CAN_BTP_ presets without CAN_BTMODE_RAW: bit/s, TS1, TS2, SJW
CLASSIC_PRESETS = [(5_000, 17, 8, 1), (800_000, 8, 2, 1), (1_000_000, 6, 2, 1)] + [
    (kbit * 1000, 14, 2, 1) for kbit in (10, 20, 50, 100, 125, 250, 500)
]
# the same, data phase at 80 MHz: bit/s, TS1, TS2, SJW, TDO, then the raw preset NP, TDO in clocks
# as from_proportions finds them (1, 2 and 4 Mbit/s: the .NET raw presets with finer quanta)
DATA_PRESETS = [
    (1_000_000, 1600, 400, 400, 1600, (2, 31, 8, 8, 64)),
    (2_000_000, 1600, 400, 400, 1600, (1, 31, 8, 8, 32)),
    (4_000_000, 800, 200, 200, 800, (1, 15, 4, 4, 16)),
    (5_000_000, 600, 200, 200, 600, (1, 11, 4, 4, 12)),
    (8_000_000, 400, 100, 100, 250, (1, 7, 2, 2, 5)),
    (10_000_000, 300, 100, 100, 200, (1, 5, 2, 2, 4)),
]


@pytest.mark.conforms("X4-21")
def test_predefined_registers_make_their_bit_rates() -> None:
    assert BTR_OF_BIT_RATE[5_000] == (0x3F, 0x7F)
    assert len(BTR_OF_BIT_RATE) == 10
    for bit_rate, registers in BTR_OF_BIT_RATE.items():
        assert BitTiming.from_btr(*registers).exact_bit_rate == bit_rate


@pytest.mark.conforms("PL-06")
@each(("btr0", "btr1", "bit_rate", "quantum_ps", "quanta", "sample"), SJA1000_TABLE)
def test_registers_mean_what_the_table_says(
    btr0: int, btr1: int, bit_rate: int, quantum_ps: int, quanta: int, sample: int
) -> None:
    timing = BitTiming.from_btr(btr0, btr1, oscillator_hz=16_000_000)

    assert (timing.bit_rate, timing.quantum_ps, timing.quanta) == (bit_rate, quantum_ps, quanta)
    assert abs(timing.sample_point * 1000 - sample) <= 0.5
    assert timing.bit_time_ps == quantum_ps * quanta
    assert timing.sample_time_ps == quantum_ps * (quanta - timing.tseg2)


@given(st.integers(0, 255), st.integers(0, 255))
def test_every_register_pair_comes_back(btr0: int, btr1: int) -> None:
    timing = BitTiming.from_btr(btr0, btr1)

    assert timing.to_btr() == (btr0, btr1)
    assert timing.triple_sampling == (btr1 >= 0x80)
    assert timing.exact_bit_rate == Fraction(
        16_000_000, 2 * ((btr0 & 63) + 1) * (3 + (btr1 & 15) + (btr1 >> 4 & 7))
    )


@given(st.integers(0, 255), st.integers(0, 255))
def test_registers_agree_with_python_can(btr0: int, btr1: int) -> None:
    can = pytest.importorskip("can")
    try:
        theirs = can.BitTiming.from_registers(8_000_000, btr0, btr1)
    except ValueError:
        return  # python-can refuses jumps and sample points that the chip takes
    ours = BitTiming.from_btr(btr0, btr1)
    assert (ours.prescaler, ours.tseg1, ours.tseg2, ours.sjw) == (
        theirs.brp,
        theirs.tseg1,
        theirs.tseg2,
        theirs.sjw,
    )
    assert abs(ours.bit_rate - theirs.bitrate) <= 1
    assert ours.sample_point * 100 == pytest.approx(theirs.sample_point)


def test_phase1_is_as_long_as_phase2_where_tseg1_allows() -> None:
    assert (BitTiming(1, 13, 2, 1).prop, BitTiming(1, 13, 2, 1).phase1) == (11, 2)
    assert (BitTiming(1, 4, 8, 1).prop, BitTiming(1, 4, 8, 1).phase1) == (1, 3)
    assert BitTiming(1, 13, 2, 1, prop=5).phase1 == 8


@pytest.mark.conforms("X4-18")
@each(("bit_rate", "ts1", "ts2", "sjw"), CLASSIC_PRESETS)
def test_classic_presets_become_the_classic_registers(bit_rate: int, ts1: int, ts2: int, sjw: int) -> None:
    timing = BitTiming.from_proportions(bit_rate, ts1, ts2, sjw, 8_000_000, limits=SJA1000)

    assert timing.to_btr() == BTR_OF_BIT_RATE[bit_rate]
    assert timing.sample_point == ts1 / (ts1 + ts2)


@pytest.mark.conforms("X4-18")
@each(("bit_rate", "ts1", "ts2", "sjw", "tdo", "raw"), DATA_PRESETS)
def test_data_presets_become_registers_of_the_same_bit(
    bit_rate: int, ts1: int, ts2: int, sjw: int, tdo: int, raw: tuple[int, int, int, int, int]
) -> None:
    timing = BitTiming.from_proportions(
        bit_rate, ts1, ts2, sjw, 80_000_000, limits=FD_DATA, tdo=tdo, triple_sampling=True
    )

    assert (timing.prescaler, timing.tseg1, timing.tseg2, timing.sjw, timing.tdo) == raw
    assert timing.exact_bit_rate == bit_rate
    assert timing.triple_sampling


@pytest.mark.conforms("X4-18")
def test_raw_values_are_checked_against_the_limits() -> None:
    timing = BitTiming.raw(1, 13, 2, 1, 8_000_000, limits=SJA1000, triple_sampling=True, tdo=3)
    assert (timing.bit_rate, timing.triple_sampling, timing.tdo) == (500_000, True, 3)
    for values, message in (
        ((65, 13, 2, 1), "prescaler 65: SJA1000 takes 1..64"),
        ((1, 17, 2, 1), "tseg1 17: SJA1000 takes 1..16"),
        ((1, 13, 9, 1), "tseg2 9: SJA1000 takes 1..8"),
        ((1, 13, 2, 5), "sjw 5: SJA1000 takes 1..4"),
        ((1, 3, 2, 1), "quanta 6: SJA1000 takes 8..25"),
    ):
        with pytest.raises(BadTiming, match=message):
            BitTiming.raw(*values, 8_000_000, limits=SJA1000)


@pytest.mark.conforms("X4-20")
def test_eight_and_two_allow_a_jump_of_one() -> None:
    timing = BitTiming.from_proportions(100_000, 8, 2, 1, 8_000_000, limits=SJA1000)
    assert (timing.quanta, timing.sample_point, timing.sjw) == (10, 0.8, 1)
    with pytest.raises(BadTiming, match="sjw 2 of 8 \\+ 2: at most 1"):
        BitTiming.from_proportions(100_000, 8, 2, 2, 8_000_000, limits=SJA1000)


@given(st.integers(-1, 70_000), st.integers(-1, 70_000), st.integers(-1, 70_000), st.integers(-1, 2_000_000))
def test_proportions_give_that_bit_rate_and_jump_or_bad_timing(
    ts1: int, ts2: int, sjw: int, bit_rate: int
) -> None:
    try:
        timing = BitTiming.from_proportions(bit_rate, ts1, ts2, sjw, 8_000_000, limits=SJA1000)
    except BadTiming:
        return
    assert abs(timing.exact_bit_rate - bit_rate) < 1
    assert timing.sjw == max(1, round(Fraction(sjw * timing.quanta, ts1 + ts2)))


@pytest.mark.conforms("PL-06")
@each("bit_rate", sorted(set(BTR_OF_BIT_RATE) - {5_000}))
def test_usual_rates_get_the_usual_registers(bit_rate: int) -> None:
    timing = BitTiming.for_bit_rate(bit_rate, clock_hz=8_000_000, limits=SJA1000)
    assert timing.to_btr() == BTR_OF_BIT_RATE[bit_rate]


@pytest.mark.conforms("PL-06")
@each(
    ("bit_rate", "sample_point"),
    [
        (125_000, 0.875),
        (500_000, 0.875),
        (800_000, 0.8),
        (1_000_000, 0.75),
        (2_000_000, 0.8),
        (4_000_000, 0.8),
        (5_000_000, 0.8125),
        (8_000_000, 0.8),
        (10_000_000, 0.75),
    ],
)
def test_an_80_mhz_clock_makes_every_common_rate(bit_rate: int, sample_point: float) -> None:
    timing = BitTiming.for_bit_rate(bit_rate)
    assert timing.exact_bit_rate == bit_rate
    assert timing.sample_point == sample_point
    assert timing.sjw == timing.phase1 == timing.tseg2


def test_a_given_jump_is_kept_or_refused() -> None:
    assert BitTiming.for_bit_rate(2_000_000, sjw=3).sjw == 3
    with pytest.raises(BadTiming, match=r"sjw 9: .* allow 1\.\.8"):
        BitTiming.for_bit_rate(2_000_000, sjw=9)


@each(
    ("bit_rate", "clock_hz", "limits", "near"),
    [
        (700_000, 8_000_000, SJA1000, "666667 and 727273"),
        (7_000_000, 80_000_000, FD_DATA, "6666667 and 7272727"),
        (1_000, 8_000_000, SJA1000, "nearest: 5000 bit"),
        (2_000_000, 8_000_000, SJA1000, "nearest: 1000000 bit"),
    ],
)
def test_an_impossible_rate_names_the_nearest(
    bit_rate: int, clock_hz: int, limits: TimingLimits, near: str
) -> None:
    for attempt in (BitTiming.for_bit_rate, BitTiming.solutions):
        with pytest.raises(BadTiming, match=near):
            attempt(bit_rate, clock_hz=clock_hz, limits=limits)
    with pytest.raises(BadTiming, match=near):
        BitTiming.search(bit_rate, clock_hz, 0.001, 100, limits)


@given(st.integers(4_000, 1_200_000))
def test_the_nearest_rates_are_the_nearest(bit_rate: int) -> None:
    reachable = {
        Fraction(8_000_000, prescaler * quanta) for prescaler in range(1, 65) for quanta in range(8, 26)
    }
    near = {round(max((rate for rate in reachable if rate <= bit_rate), default=Fraction(0)))}
    near |= {round(min((rate for rate in reachable if rate >= bit_rate), default=Fraction(0)))}
    if any(bit_rate in (int(rate), round(rate)) for rate in reachable):
        made = BitTiming.for_bit_rate(bit_rate, clock_hz=8_000_000, limits=SJA1000).exact_bit_rate
        assert bit_rate in (int(made), round(made))
        return
    with pytest.raises(BadTiming) as caught:
        BitTiming.for_bit_rate(bit_rate, clock_hz=8_000_000, limits=SJA1000)
    named = str(caught.value).split("nearest: ")[1].split()
    assert {int(word) for word in named if word.isdigit()} == near - {0}


@pytest.mark.conforms("PL-06")
def test_solutions_are_complete() -> None:
    by_trial = {
        (prescaler, tseg1, tseg2)
        for prescaler in range(1, 65)
        for tseg1 in range(1, 17)
        for tseg2 in range(1, 9)
        if tseg1 + tseg2 >= 7 and prescaler * (1 + tseg1 + tseg2) * 250_000 == 8_000_000
    }
    found = BitTiming.solutions(250_000, 8_000_000, limits=SJA1000)
    assert {(timing.prescaler, timing.tseg1, timing.tseg2) for timing in found} == by_trial
    assert len(found) == len(by_trial)


@pytest.mark.conforms("PL-06")
def test_solutions_are_sorted_and_cover_fd() -> None:
    classic = BitTiming.solutions(500_000, 8_000_000, limits=SJA1000, sample_point=0.8)
    assert [abs(timing.sample_point - 0.8) for timing in classic] == sorted(
        abs(timing.sample_point - 0.8) for timing in classic
    )
    for limits in (FD_NOMINAL, FD_DATA):
        for timing in BitTiming.solutions(2_000_000, limits=limits):
            limits.check(timing.prescaler, timing.tseg1, timing.tseg2, timing.sjw)
            assert timing.exact_bit_rate == 2_000_000


def test_a_rate_cut_to_whole_bits_stands_for_the_exact_one() -> None:
    assert BitTiming.for_bit_rate(33_333, clock_hz=8_000_000, limits=SJA1000).exact_bit_rate == Fraction(
        100_000, 3
    )
    assert BitTiming.for_bit_rate(6_666_666).exact_bit_rate == Fraction(20_000_000, 3)


@each(
    ("make", "named"),
    [
        (lambda: BitTiming(0, 13, 2, 1), "prescaler 0"),
        (lambda: BitTiming(1, 0, 2, 1), "tseg1 0"),
        (lambda: BitTiming(1, 13, 2.5, 1), "tseg2 2.5"),  # type: ignore[arg-type]
        (lambda: BitTiming(1, 13, 2, 1, clock_hz=0), "clock_hz 0"),
        (lambda: BitTiming(1, 13, 2, 1, prop=14), "prop 14"),
        (lambda: BitTiming(1, 13, 2, 1, tdo=-1), "tdo -1"),
        (lambda: BitTiming(1, 13, 9, 1).to_btr(), "tseg2 9"),
        (lambda: BitTiming.from_btr(256, 0), "BTR0 256"),
        (lambda: BitTiming.from_btr(0, -1), "BTR1 -1"),
        (lambda: BitTiming.from_btr(0, 0x14, 16_000_001), "oscillator_hz 16000001"),
        (lambda: BitTiming.for_bit_rate(0), "bit_rate 0"),
        (lambda: BitTiming.for_bit_rate(500_000, 1.0), "sample_point 1.0"),
        (lambda: BitTiming.for_bit_rate(500_000, float("nan")), "sample_point nan"),
        (lambda: BitTiming.for_bit_rate(500_000, clock_hz=-1), "clock_hz -1"),
        (lambda: BitTiming.from_proportions(500_000, 0, 2, 1, 8_000_000), "ts1 0"),
        (lambda: BitTiming.from_proportions(500_000, 14, 2, 65_536, 8_000_000), "sjw 65536"),
        (lambda: BitTiming.search(500_000, 8_000_000, -0.1, 0), "oscillator_tolerance -0.1"),
        (lambda: BitTiming.search(500_000, 8_000_000, 0.1, float("inf")), "propagation_delay_ns inf"),
    ],
)
def test_a_bad_value_is_named(make: object, named: str) -> None:
    with pytest.raises(BadTiming, match=named):
        make()  # type: ignore[operator]
