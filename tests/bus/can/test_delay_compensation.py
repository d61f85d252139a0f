"""A sender that reads itself late: what becomes of its frames, with and without delay compensation.

At 5 Mbit/s a bit of the data phase has 200 ns, and its sample point is at 162.5 ns.
"""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import ControllerOptions, DelayCompensation, ErrorKind, EventKind, Frame, Lab, LabBus, LabNode
from tests.cases import each
from tests.effort import examples

pytestmark = pytest.mark.core

FRAME = Frame(0x123, bytes(range(64)), fd=True, bit_rate_switch=True)
SAMPLE_NS = 162.5
BIT_NS = 200


def bench(lab: Lab, options: ControllerOptions) -> tuple[LabBus, LabNode, LabNode]:
    bus = lab.can_bus(bit_rate=500_000, data_bit_rate=5_000_000)
    sender, receiver = bus.node("sender", options=options), bus.node("receiver")
    sender.events()
    return bus, sender, receiver


def passes(options: ControllerOptions, frame: Frame = FRAME, *, bitwise: bool = False) -> bool:
    """The frame gets through at once; else it was a bit error of the data phase, and nothing came."""
    with Lab() as lab:
        bus, sender, receiver = bench(lab, options)
        bus.wire.bitwise = bitwise
        sender.send(frame, single_shot=True)
        lab.run_for(0.002)
        errors = [event.error for event in sender.events(EventKind.ERROR)]
        assert errors in ([], [ErrorKind.FAST_DATA_BIT])
        assert (sender.tec, receiver.waiting) == ((8, 0) if errors else (0, 1))
        return not errors


@pytest.mark.parametrize("bitwise", [False, True])
def test_without_compensation_the_delay_must_not_reach_the_sample_point(bitwise: bool) -> None:
    assert passes(ControllerOptions(SAMPLE_NS), bitwise=bitwise)
    assert not passes(ControllerOptions(SAMPLE_NS + 0.5), bitwise=bitwise)


@each("delay_ns", [0, 163, 255, 400, 999.5, 1_500])
def test_with_compensation_it_passes(delay_ns: float) -> None:
    assert passes(ControllerOptions(delay_ns, DelayCompensation()))
    assert passes(ControllerOptions(delay_ns, DelayCompensation()), bitwise=True)


@each("bitwise", [False, True])
@each(
    ("compensation", "first_ns", "last_ns"),
    [  # the second sample point has to be in the bit's echo
        (DelayCompensation(0), 0, 1_500),
        (DelayCompensation(BIT_NS - 1), 0, 1_500),
        (DelayCompensation(300, measured=False), 101, 300),
        (DelayCompensation(100, filter_ns=300), 101, 1_500),
    ],
)
def test_where_the_second_sample_point_may_be(
    compensation: DelayCompensation, first_ns: int, last_ns: int, bitwise: bool
) -> None:
    assert passes(ControllerOptions(first_ns, compensation), bitwise=bitwise)
    assert passes(ControllerOptions(last_ns, compensation), bitwise=bitwise)
    if first_ns:
        assert not passes(ControllerOptions(first_ns - 1, compensation), bitwise=bitwise)
    if last_ns < 1_500:
        assert not passes(ControllerOptions(last_ns + 1, compensation), bitwise=bitwise)


@examples(60)
@given(st.integers(0, 2_000), st.integers(0, 1_000), st.integers(0, 1_000) | st.just(0), st.booleans())
def test_a_frame_passes_where_every_bit_is_looked_at_in_its_own_echo(
    delay_ns: int, offset_ns: int, filter_ns: int, measured: bool
) -> None:
    filter_ns = filter_ns if measured else 0
    delay_ns = min(delay_ns, 1_500)  # the sample point of the nominal phase is at 1,750
    second_ns = max(delay_ns + offset_ns, filter_ns) if measured else offset_ns
    options = ControllerOptions(delay_ns, DelayCompensation(offset_ns, filter_ns, measured))
    wanted = delay_ns <= second_ns < delay_ns + BIT_NS
    assert passes(options) == wanted
    assert passes(options, bitwise=True) == wanted


def test_an_offset_of_a_bit_looks_at_the_next_one() -> None:
    assert not passes(ControllerOptions(255, DelayCompensation(BIT_NS)))


def test_only_the_data_phase_is_quick() -> None:
    slow = Frame(0x123, bytes(range(64)), fd=True)
    for frame in (slow, Frame(0x123, b"\x55" * 8)):
        assert passes(ControllerOptions(400), frame)
        assert passes(ControllerOptions(400, DelayCompensation(700)), frame)


def test_the_offset_of_a_timing_is_one_of_the_compensation() -> None:
    """CANBTP.wTDO and BitTiming.tdo: periods of the clock."""
    with Lab() as lab:
        bus, late, _ = bench(lab, ControllerOptions(255))
        data = late.settings.data_timing
        assert data is not None
        offset = round(SAMPLE_NS * data.clock_hz / 1e9)
        timing = type(data)(data.prescaler, data.tseg1, data.tseg2, data.sjw, data.clock_hz, tdo=offset)
        compensating = bus.node("tdo", data_timing=timing, options=ControllerOptions(255))
        for node, passed in ((late, 0), (compensating, 1)):
            before = bus.frames
            node.send(FRAME, single_shot=True)
            lab.run_for(0.002)
            assert bus.frames - before == passed


def test_a_bit_that_is_read_wrong_is_told_at_the_next_ordinary_sample_point() -> None:
    """The same bit is disturbed; compensated by two bits, the sender goes on for two bits more."""
    told = {}
    for delay_ns in (0, 400):
        with Lab() as lab:
            bus, sender, _ = bench(lab, ControllerOptions(delay_ns, DelayCompensation()))
            bus.faults.flip(bit=60, seen_by="sender")
            sender.send(FRAME)
            lab.run_for(0.002)
            (error,) = sender.events(EventKind.ERROR)
            assert (error.error, bus.frames, bus.error_frames) == (ErrorKind.FAST_DATA_BIT, 1, 1)
            told[delay_ns] = (error.bit, error.timestamp_ns)
    assert told[0][0] == 60
    assert told[400][0] == 62
    assert told[400][1] - told[0][1] == 2 * BIT_NS


def test_what_somebody_else_drives_is_found_too() -> None:
    """A receiver's error flag in the data phase: the sender sees it at its second sample points."""
    with Lab() as lab:
        bus, sender, receiver = bench(lab, ControllerOptions(255, DelayCompensation()))
        bus.faults.flip(bit=100, seen_by=receiver)
        sender.send(FRAME)
        lab.run_for(0.002)
        assert (bus.error_frames, bus.frames, receiver.receive_many(2)[0].data) == (1, 1, FRAME.data)
        assert [error.error for error in sender.events(EventKind.ERROR)] == [ErrorKind.FAST_DATA_BIT]


def test_a_glitch_in_front_of_the_edge_is_measured_unless_the_filter_is_longer() -> None:
    for filter_ns, frames in ((0, 0), (SAMPLE_NS + 300, 1)):
        with Lab() as lab:
            bus, sender, _ = bench(lab, ControllerOptions(400, DelayCompensation(filter_ns=filter_ns)))
            res = bus.faults.place("frame", 15, frame_id=0x123)
            bus.faults.glitch("dominant", at=res, from_ns=50, width_ns=50, seen_by=sender)
            sender.send(FRAME, single_shot=True)
            lab.run_for(0.002)
            assert bus.frames == frames


def test_two_senders_of_one_identifier_still_collide() -> None:
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000, data_bit_rate=5_000_000)
        nodes = [bus.node(f"n{k}", options=ControllerOptions(255, DelayCompensation())) for k in range(2)]
        bus.node("receiver")
        for k, node in enumerate(nodes):
            node.send(Frame(0x123, bytes([k] * 8), fd=True, bit_rate_switch=True), single_shot=True)
        lab.run_for(0.002)
        assert (bus.frames, bus.error_frames) == (0, 1)
