"""Any set of timings: whole frames are taken only where the bit level gives the very same (docs/whole-frames.md).

Each seed draws a bus: rates, clocks, prescalers, sample points, SJW, oscillators, a cable, FD ratios from 1 to 16,
delay compensation, two to four nodes that send, arbitrate, stop, start and lose their plug, noise, faults. Both ways,
and the change between them at any moment, must give every observer the same: frames, errors, counters, states, events,
loads, stamps.

    python -m tests.bus.can.test_whole_frames SECONDS [FIRST SEED]

plays new seeds for so long, and prints how many sets there were and which of them differed.
"""

from __future__ import annotations

import random
import sys
import time
from typing import Any

import pytest

from canwire import (
    BitTiming,
    ControllerOptions,
    DelayCompensation,
    ErrorState,
    Frame,
    Lab,
    LabBus,
    LabNode,
)
from tests.bus.can.test_two_ways import look_at_random_moments, plan_a_frame, start_with_counters, summary
from tests.effort import seeds

pytestmark = [pytest.mark.conforms("N-62"), pytest.mark.core]

SEEDS_A_TEST = 20
DIFFERED = (704_538, 724_617, 730_054, 734_771, 736_019, 738_323, 743_032, 1_026_051, 1_065_766)
SPAN_BITS, END_BITS = 1_500, 4_000
CLOCKS = (8_000_000, 16_000_000, 20_000_000, 24_000_000, 40_000_000, 80_000_000)
RATES = (50_000, 83_333, 125_000, 250_000, 333_333, 500_000, 800_000, 1_000_000)


@pytest.mark.finding("wire-2 1", "wire-2 5")
@pytest.mark.conforms("G-06", "G-13")
@pytest.mark.parametrize("first", range(0, 160, SEEDS_A_TEST))
def test_random_timings_give_the_same_both_ways(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        assert difference(seed) == "", f"seed {seed}"


@pytest.mark.parametrize("seed", DIFFERED)
def test_sets_that_differed_once_do_so_no_more(seed: int) -> None:
    """What they found is tests/bus/can/test_leaving.py."""
    assert difference(seed) == ""


# from the examination


@pytest.mark.finding("wire-2 1")
@pytest.mark.parametrize("bitwise", [False, True])
@pytest.mark.parametrize(
    ("data_rate", "data_sample", "others"),
    [(4_000_000, 0.75, 0.75), (8_000_000, 0.8, 0.5), (2_000_000, 0.75, 0.3)],
)
def test_unlike_nominal_sample_points_ruin_fd_frames(
    lab: Lab, data_rate: int, data_sample: float, others: float, bitwise: bool
) -> None:
    """The rate switches at the nominal sample point: each node's data bits begin somewhere else."""
    data = BitTiming.for_bit_rate(data_rate, data_sample)
    usual, other = (BitTiming.for_bit_rate(500_000, sample) for sample in (0.875, others))
    bus = lab.can_bus(timing=usual, data_timing=data)
    bus.wire.bitwise = bitwise
    a, b = bus.node("a"), bus.node("b", timing=other)
    a.send_many([Frame(k, bytes(range(12)), fd=True, bit_rate_switch=True) for k in range(10)])
    lab.run_for(0.05)
    assert (a.delivered, b.waiting) == (0, 0)
    assert a.state in (ErrorState.ERROR_PASSIVE, ErrorState.BUS_OFF)


@pytest.mark.finding("wire-2 1")
def test_unlike_nominal_sample_points_do_no_harm_without_a_second_rate(lab: Lab) -> None:
    usual, other = (BitTiming.for_bit_rate(500_000, sample) for sample in (0.875, 0.75))
    bus = lab.can_bus(timing=usual, data_bit_rate=4_000_000)
    a, b = bus.node("a"), bus.node("b", timing=other)
    frames = [Frame(1, b"\x12"), Frame(2, bytes(12), fd=True)]
    a.send_many(frames)
    lab.run_until_idle()
    assert b.receive_many(9) == frames
    assert bus.wire.bits.clocks == []  # and nothing went bit by bit


@pytest.mark.finding("wire-2 5")
def test_drifting_oscillators_have_the_same_stamps_both_ways() -> None:
    ends = []
    for bitwise in (False, True):
        with Lab() as lab:
            bus = lab.can_bus(bit_rate=500_000)
            bus.wire.bitwise = bitwise
            a, b = bus.node("a", oscillator_ppm=50), bus.node("b", oscillator_ppm=-50)
            for k in range(150):
                a.send(Frame(0x100 + k, bytes([k])))
                b.send(Frame(0x101 + k, bytes([k])))
            lab.run_until_idle()
            ends.append([[frame.timestamp_ns for frame in node.receive_many(999)] for node in (a, b)])
    assert len(ends[0][0]) == 150
    assert ends[0] == ends[1]


# a seed's bus


def difference(seed: int) -> str:
    """What an observer of this seed's bus could tell the ways apart by, or ""."""
    bitwise = outcome(seed, True)
    for way in (False, None):
        for told, other in zip(bitwise, outcome(seed, way), strict=True):
            for name, seen in told.items():
                if other[name] != seen:
                    how = "changing" if way is None else "whole"
                    return f"{name} at {told['bus'][0]} ns: {seen} bit by bit, {other[name]} {how}"
    return ""


def outcome(seed: int, bitwise: bool | None) -> list[dict[str, Any]]:
    """What everybody saw on this seed's bus, at random moments and at the end; None changes the way all the time."""
    chance = random.Random(seed)
    with Lab(seed=seed) as lab:
        bus, nodes, bit_ns = some_bus(lab, chance)
        span_ns, end_ns = SPAN_BITS * bit_ns, END_BITS * bit_ns
        if bitwise is None:
            keep_changing(lab, bus, random.Random(seed), bit_ns)
        else:
            bus.wire.bitwise = bitwise
        for _ in range(chance.randrange(1, 20)):
            plan_a_frame(lab, nodes, chance, chance.random() < 0.8, span_ns=span_ns)
        if chance.random() < 0.2:
            start_with_counters(nodes[-1], chance.randrange(200), chance.randrange(200))
        if chance.random() < 0.4:
            disturb(bus, nodes, chance)
        for _ in range(chance.choice([0, 0, 0, 1, 3])):
            restart_in_mid_frame(lab, bus, chance.choice(nodes), chance, span_ns)
        seen = look_at_random_moments(lab, bus, nodes, random.Random(seed), looks=30, end_ns=2 * span_ns)
        lab.run_until(end_ns)
        return [*seen, summary(lab, bus, nodes)]


def disturb(bus: LabBus, nodes: list[LabNode], chance: random.Random) -> None:
    """Bits read wrong by chance, or by script, or a fault that waits for a frame that never comes."""
    if chance.random() < 0.5:
        bus.faults.noise(chance.choice([1e-4, 1e-3]))
    if chance.random() < 0.5:
        seen_by = chance.choice(["all", "receivers", "sender", nodes[-1]])
        bus.faults.flip(bit=chance.randrange(80), times=2, seen_by=seen_by)
    if chance.random() < 0.5:
        bus.faults.flip(bit=12, frame_id=0x7F7, extended=False)


def restart_in_mid_frame(lab: Lab, bus: LabBus, node: LabNode, chance: random.Random, span_ns: int) -> None:
    """It stops, and starts again at once, or later, or its plug is out for a while."""
    at_ns = chance.randrange(span_ns)
    back_ns = at_ns + chance.choice([0, span_ns // 300, span_ns // 20, span_ns])
    if chance.random() < 0.5:
        lab.at(at_ns, node.stop)
        lab.at(back_ns, node.start)
    else:
        lab.at(at_ns, lambda: bus.faults.disconnect(node))
        lab.at(back_ns, lambda: bus.faults.reconnect(node))


def keep_changing(lab: Lab, bus: LabBus, chance: random.Random, bit_ns: int) -> None:
    def change() -> None:
        bus.wire.bitwise = not bus.wire.bitwise

    for at_ns in range(0, END_BITS * bit_ns, 200 * bit_ns):
        lab.at(at_ns + chance.randrange(200 * bit_ns), change, background=True)


# a bus of random timings


def some_bus(lab: Lab, chance: random.Random) -> tuple[LabBus, list[LabNode], int]:
    """The bus, its nodes, and about how long a bit lasts on it."""
    rate = chance.choice(RATES)
    clock_hz = chance.choice([hertz for hertz in CLOCKS if round(hertz / rate) >= 8])
    periods = round(clock_hz / rate)
    nominal = drawn_timing(chance, clock_hz, periods)
    fd = chance.random() < 0.6
    data_periods = max(4, round(periods / chance.choice([1, 2, 4, 5, 8, 10, 12, 16]))) if fd else 0
    data = drawn_timing(chance, clock_hz, min(periods, data_periods)) if fd else None
    length_m = chance.choice([0] * 9 + [1, 25, 100])
    bus = lab.can_bus(timing=nominal, data_timing=data, length_m=length_m, iso_fd=chance.random() < 0.8)
    usual = ["nothing", "nothing", "segments", "sjw", "sjw"]
    unlike = chance.choice([*usual, "segments", "data", "all", "oscillators", "rate"])
    nodes = [some_node(bus, chance, f"n{k}", unlike) for k in range(chance.randrange(2, 5))]
    return bus, nodes, max(1, nominal.bit_time_ps // 1000)


def some_node(bus: LabBus, chance: random.Random, name: str, unlike: str) -> LabNode:
    """One that differs from the bus in this, perhaps."""
    nominal, data = bus.timing, bus.data_timing
    periods = nominal.prescaler * nominal.quanta
    if unlike in ("segments", "all"):
        nominal = drawn_timing(chance, nominal.clock_hz, periods)
    if unlike == "rate" and chance.random() < 0.3:
        nominal = drawn_timing(chance, nominal.clock_hz, periods + chance.choice([-1, 1, periods]))
    if unlike == "sjw":
        nominal = with_jump(chance, nominal)
    if data is not None:
        if unlike in ("data", "all"):
            data = drawn_timing(chance, data.clock_hz, data.prescaler * data.quanta)
        if unlike == "sjw":
            data = with_jump(chance, data)
        if data.exact_bit_rate < nominal.exact_bit_rate:
            data = nominal
    ppm = chance.choice([-200, -50, 0, 50, 200, 3000]) if unlike in ("oscillators", "all") else 0
    listen_only = name == "n2" and chance.random() < 0.3
    node = bus.node(
        name, timing=nominal, data_timing=data, fd=chance.random() < 0.95, oscillator_ppm=ppm, listen_only=listen_only,
        options=some_options(chance, nominal, data or nominal),
    )  # fmt: skip
    node.events()
    return node


def some_options(chance: random.Random, nominal: BitTiming, data: BitTiming) -> ControllerOptions:
    if chance.random() < 0.5:
        return ControllerOptions()
    loop_ns = min(2000, chance.choice([0, 50, 150, 255]), nominal.sample_time_ps // 1000)
    compensation = None
    if chance.random() < 0.7:
        offset_ns = chance.choice([None, None, 30, data.sample_time_ps // 2000])
        measured = offset_ns is None or chance.random() < 0.7
        compensation = DelayCompensation(offset_ns, chance.choice([0, 0, 100]) if measured else 0, measured)
    return ControllerOptions(
        loop_ns, compensation, edge_filter=chance.random() < 0.3, fd_tolerant=chance.random() < 0.5
    )


def drawn_timing(chance: random.Random, clock_hz: int, periods: int) -> BitTiming:
    """A bit of so many periods of the clock, divided by chance."""
    prescalers = [n for n in range(1, 65) if periods % n == 0 and 4 <= periods // n <= 400]
    prescaler = chance.choice(prescalers or [1])
    quanta = periods // prescaler
    tseg2 = max(1, min(quanta - 2, round(quanta * chance.uniform(0.05, 0.5))))
    tseg1 = quanta - 1 - tseg2
    return with_jump(chance, BitTiming(prescaler, tseg1, tseg2, 1, clock_hz=clock_hz))


def with_jump(chance: random.Random, timing: BitTiming) -> BitTiming:
    widest = max(1, min(timing.phase1, timing.tseg2))
    sjw = chance.randint(1, widest)
    return BitTiming(timing.prescaler, timing.tseg1, timing.tseg2, sjw, clock_hz=timing.clock_hz)


# a long run


def play(seconds: float, first: int) -> int:
    """New seeds for so long; the number of those that differ."""
    until = time.monotonic() + seconds
    seed, wrong = first, 0
    while time.monotonic() < until:
        found = difference(seed)
        if found:
            wrong += 1
            print(f"seed {seed}: {found[:400]}", flush=True)
        seed += 1
    print(f"{seed - first} sets from seed {first} on, {wrong} of them differ")
    return wrong


if __name__ == "__main__":
    sys.exit(play(float(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1_000) > 0)
