"""Clocks that disagree and cables that are too long: what keeps a bus in step, and what does not.

Source: ISO 11898-1 11.3; reference/can-protocol.md section 8; the medium table of the INduCAN104 manual.
"""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BitTiming, ErrorKind, EventKind, Frame, Lab, LabNode
from tests.cases import each
from tests.effort import examples

pytestmark = pytest.mark.core

RATES = (50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)
# five dominant, five recessive bits and so on: a falling edge only every ten bits
HARDEST = Frame(0x078, b"\x3c" * 8)


# rates that do not fit


@pytest.mark.conforms("G-12")
@examples(30)
@given(
    rates=st.lists(st.sampled_from(RATES), min_size=2, max_size=2, unique=True),
    data=st.binary(max_size=8),
    id=st.integers(0, 0x7FF),
    both=st.booleans(),
)
def test_nodes_of_different_bit_rates_see_errors_and_never_garbage(
    rates: list[int], data: bytes, id: int, both: bool
) -> None:
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=rates[0])
        a, b = bus.node("a"), bus.node("b", bit_rate=rates[1])
        a.events()
        b.events()
        a.send(Frame(id, data))
        if both:
            b.send(Frame(id ^ 0x155, data))
        lab.run_for(max(0.002, 250 / min(rates)))
        assert (a.waiting, b.waiting) == (0, 0)
        if max(rates) < 3 * min(rates):  # a much quicker node's error flag may fill a slow sender's ACK slot
            assert (a.delivered, b.delivered) == (0, 0)
        assert a.delivered or a.events(EventKind.ERROR)
        if both or max(rates) <= 4 * min(rates):  # a much slower listener may take a frame for a glitch
            assert b.events(EventKind.ERROR)


@pytest.mark.conforms("G-12")
@pytest.mark.parametrize("wrong", [1_000_000, 4_000_000, 5_000_000])
def test_another_data_rate_destroys_only_the_frames_that_switch(lab: Lab, wrong: int) -> None:
    bus = lab.can_bus(bit_rate=500_000, data_bit_rate=2_000_000)
    data_timing = BitTiming.for_bit_rate(wrong, clock_hz=80_000_000)
    a, b = bus.node("a"), bus.node("b", data_timing=data_timing)
    plain, slow = Frame(0x100, b"\x12\x34"), Frame(0x101, bytes(range(12)), fd=True)
    a.send_many([plain, slow])
    lab.run_until_idle()
    assert b.receive_many(9) == [plain, slow]
    a.events()
    b.events()
    a.send(Frame(0x102, bytes(range(12)), fd=True, bit_rate_switch=True))
    lab.run_for(0.02)
    assert (b.waiting, a.delivered) == (0, 2)
    assert a.events(EventKind.ERROR)
    assert b.events(EventKind.ERROR)


def test_a_node_set_to_the_right_rate_afterwards_joins_in(lab: Lab) -> None:
    bus = lab.can_bus(bit_rate=500_000)
    a, b = bus.node("a"), bus.node("b", bit_rate=250_000)
    a.send(Frame(0x123, b"\x11"))
    lab.run_for(0.02)
    assert b.waiting == 0
    b.stop()
    b.reconfigure(a.settings)
    b.start()
    lab.run_until_idle()
    assert b.receive_many(9) == [Frame(0x123, b"\x11")]


# oscillators

USUAL = BitTiming.for_bit_rate(500_000, clock_hz=80_000_000)
TIMINGS = {
    "usual": USUAL,
    "SJA1000": BitTiming(1, 13, 2, 1, clock_hz=8_000_000),
    "75 %, narrow": BitTiming(1, 11, 4, 1, clock_hz=8_000_000),
    "75 %, wide": BitTiming(1, 11, 4, 4, clock_hz=8_000_000),
    "best there is": BitTiming(2, 5, 4, 4, clock_hz=10_000_000, prop=1),
}


def passes(timing: BitTiming, sender_ppm: float, receiver_ppm: float, *, frames: int = 3) -> bool:
    """Do the hardest frames get from one to the other, bit by bit, without a single error?"""
    with Lab() as lab:
        bus = lab.can_bus(timing=timing)
        bus.wire.bitwise = True
        a = bus.node("a", oscillator_ppm=sender_ppm)
        b = bus.node("b", oscillator_ppm=receiver_ppm)
        a.send_many([HARDEST, Frame(0x7FF, bytes(8)), Frame(0x0, b"\xff" * 8)] * frames)
        lab.run_for(frames * 3 * 160 / timing.bit_rate)
        return bus.error_frames == 0 and (a.delivered, b.waiting) == (3 * frames, 3 * frames)


@pytest.mark.conforms("G-13")
@each("timing", TIMINGS.values(), ids=TIMINGS.keys())
@each("share", [0.5, 0.98])
@each("direction", [1, -1])
def test_oscillators_within_the_tolerance_stay_in_step(
    timing: BitTiming, share: float, direction: int
) -> None:
    """Each may be off by the tolerance, one fast and one slow."""
    ppm = direction * share * timing.tolerance * 1e6
    assert passes(timing, ppm, -ppm)
    assert passes(timing, ppm, ppm)


@pytest.mark.conforms("G-13")
@each("ppm", [-15_000, -20_000, -30_000])
def test_a_slow_receiver_beyond_condition_1_loses_step(ppm: int) -> None:
    """At 87.5 % it samples late already, and its jump repairs no more than 1.25 % in ten bits."""
    narrow = TIMINGS["SJA1000"]
    assert 2 * narrow.condition_1 < -ppm * 1e-6
    assert not passes(narrow, 0, ppm)


@pytest.mark.conforms("G-13")
@each("ppm", [-15_000, -20_000, -30_000])
def test_the_same_offset_passes_with_an_earlier_sample_and_a_wider_jump(ppm: int) -> None:
    best = TIMINGS["best there is"]
    assert 2 * best.tolerance > -ppm * 1e-6
    assert passes(best, 0, ppm)
    assert passes(best, 0, -ppm)
    assert passes(best, ppm / 2, -ppm / 2)


@pytest.mark.conforms("G-13")
def test_a_fast_receiver_fails_too() -> None:
    """It samples early: that takes longer to matter, and the jump of a quantum does not keep up."""
    early = BitTiming(1, 7, 8, 1, clock_hz=8_000_000, prop=1)
    assert early.sample_point == 0.5
    assert passes(early, 0, early.tolerance * 1.9e6)
    assert not passes(early, 0, 30_000)


@pytest.mark.conforms("G-13")
def test_the_jump_width_alone_decides() -> None:
    narrow, wide = TIMINGS["75 %, narrow"], TIMINGS["75 %, wide"]
    assert narrow.sample_point == wide.sample_point
    ppm = -18_000
    assert 2 * narrow.condition_1 < 0.018 < 2 * wide.tolerance
    assert not passes(narrow, 0, ppm)
    assert passes(wide, 0, ppm)


@pytest.mark.conforms("G-13")
@pytest.mark.parametrize("ppm", [-40_000, 40_000])
def test_a_node_out_of_step_sees_errors_and_never_garbage(lab: Lab, ppm: int) -> None:
    bus = lab.can_bus(timing=TIMINGS["SJA1000"])
    a, b = bus.node("a"), bus.node("b", oscillator_ppm=ppm)
    b.events()
    a.send(HARDEST)
    lab.run_for(0.02)
    assert set(b.receive_many(99)) <= {HARDEST}
    assert ppm > 0 or b.events(EventKind.ERROR)


@pytest.mark.conforms("G-13")
def test_a_sender_s_clock_sets_the_length_of_its_frames(lab: Lab) -> None:
    bus = lab.can_bus(bit_rate=500_000)
    a, b = bus.node("a", oscillator_ppm=-1000), bus.node("b")
    a.send(Frame(0x2AA, b"\xaa" * 8))
    frame = b.receive(timeout=0.1)
    assert frame is not None
    # but for the bits since the last edge, which a receiver counts by its own
    assert frame.timestamp_ns == pytest.approx(108 * 2000 * 1.001, abs=18 * 2)


# cables

LONGEST = [(1_000_000, 25, 1), (800_000, 50, 1), (500_000, 100, 1), (250_000, 250, 2), (125_000, 500, 3)]
by_rate = pytest.mark.parametrize(("bit_rate", "length_m", "more_m"), LONGEST, ids=lambda value: str(value))
OPTO_COUPLER_NS, OPTO_COUPLER_M = 75, 15


def contest(
    lab: Lab, bit_rate: int, length_m: float, *, node_delay_ns: float = 0.0, bitwise: bool = True
) -> tuple[LabNode, LabNode, LabNode]:
    """Two senders who arbitrate at the ends of a cable, and a third node; for some 40 frames' time."""
    bus = lab.can_bus(bit_rate=bit_rate, length_m=length_m, node_delay_ns=node_delay_ns)
    bus.wire.bitwise = bitwise
    a, b, c = (bus.node(name) for name in "abc")
    for node in (a, b, c):
        node.events()
    for k in range(5):
        a.send(Frame(0x123, bytes([k])))
        b.send(Frame(0x124 + k, bytes([k])))
    lab.run_for(40 * 80 / bit_rate)
    return a, b, c


@pytest.mark.conforms("G-21")
@pytest.mark.parametrize("bitwise", [False, True], ids=["whole frames", "bit by bit"])
@by_rate
def test_the_table_s_lengths_work(lab: Lab, bit_rate: int, length_m: int, more_m: int, bitwise: bool) -> None:
    a, b, c = contest(lab, bit_rate, length_m, bitwise=bitwise)
    assert (a.delivered, b.delivered, c.waiting) == (5, 5, 10)
    assert lab.buses["can0"].error_frames == 0


@pytest.mark.conforms("G-21")
@by_rate
def test_beyond_the_table_s_lengths_arbitration_and_acknowledge_fail(
    lab: Lab, bit_rate: int, length_m: int, more_m: int
) -> None:
    a, b, _ = contest(lab, bit_rate, length_m + more_m)
    assert (a.delivered, b.delivered) == (0, 0)
    assert lab.buses["can0"].error_frames > 0
    assert a.tec > 0
    assert b.tec > 0


@pytest.mark.conforms("G-21")
@by_rate
def test_beyond_the_table_s_lengths_the_acknowledge_comes_too_late(
    lab: Lab, bit_rate: int, length_m: int, more_m: int
) -> None:
    """A single sender, nobody to arbitrate with: only the ACK slot needs an answer in time."""
    bus = lab.can_bus(bit_rate=bit_rate, length_m=length_m + more_m)
    a, _ = bus.node("a"), bus.node("b")
    a.events()
    a.send(Frame(0x123, b"\x11"))
    lab.run_for(300 / bit_rate)
    errors = a.events(EventKind.ERROR)
    assert errors
    assert errors[0].error is ErrorKind.ACK
    assert a.delivered == 0


@pytest.mark.conforms("G-21")
@by_rate
def test_an_opto_coupler_is_worth_15_metres(lab: Lab, bit_rate: int, length_m: int, more_m: int) -> None:
    """One at each of the two nodes takes 30 m from the table's length."""
    left_m = length_m - 2 * OPTO_COUPLER_M
    if left_m < 0:
        left_m = 0  # 1 Mbit/s: two couplers are more than its 25 m allow
        a, b, _ = contest(lab, bit_rate, left_m, node_delay_ns=OPTO_COUPLER_NS)
        assert (a.delivered, b.delivered) == (0, 0)
        return
    a, b, c = contest(lab, bit_rate, left_m, node_delay_ns=OPTO_COUPLER_NS)
    assert (a.delivered, b.delivered, c.waiting) == (5, 5, 10)
    lab.buses.clear()
    a, b, _ = contest(lab, bit_rate, left_m + more_m, node_delay_ns=OPTO_COUPLER_NS)
    assert (a.delivered, b.delivered) == (0, 0)


@pytest.mark.conforms("G-21")
def test_a_lower_rate_is_the_cure_for_a_long_cable(lab: Lab) -> None:
    a, b, _ = contest(lab, 500_000, 240)
    assert (a.delivered, b.delivered) == (0, 0)
    lab.buses.clear()
    a, b, _ = contest(lab, 250_000, 240)
    assert (a.delivered, b.delivered) == (5, 5)


def test_a_long_cable_within_its_limits_changes_no_time(lab: Lab) -> None:
    bus = lab.can_bus(bit_rate=125_000, length_m=400)
    a, b = bus.node("a"), bus.node("b")
    a.send(Frame(0x2AA, b"\xaa" * 8))
    frame = b.receive(timeout=0.1)
    assert frame is not None
    assert frame.timestamp_ns == pytest.approx(108 * 8000, abs=8000)
