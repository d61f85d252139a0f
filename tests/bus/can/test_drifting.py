"""Bits of clocks that disagree, many in one step or each in two: nothing outside or inside may be different."""

from __future__ import annotations

import random
from typing import Any

import pytest

from canwire import BitTiming, Frame, Lab, LabBus, LabNode
from canwire.bus.can.node import Node
from tests.bus.can.test_coasting import END_NS, come_and_go, disturb, look_inside
from tests.bus.can.test_two_ways import plan_a_frame, start_with_counters, summary
from tests.effort import seeds

pytestmark = pytest.mark.core

SEEDS_A_TEST = 15
PPM = (-3000.0, -900.0, -50.0, -1.0, 0.0, 0.3, 40.0, 2000.0, 9000.0)
FRAME = Frame(0x123, bytes(range(8)))
FD_FRAME = Frame(0x123, bytes(range(64)), fd=True, bit_rate_switch=True)


@pytest.mark.parametrize("first", range(0, 120, SEEDS_A_TEST))
def test_stretches_of_drifting_clocks_are_the_bits_that_they_replace(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        one, other = (outcome(seed, coasts) for coasts in (True, False))
        assert one == other, f"seed {seed}"


@pytest.mark.parametrize(("frame", "length", "most"), [(FRAME, 118, 16), (FD_FRAME, 690, 20)])
def test_most_bits_of_a_drifting_senders_frame_are_taken_at_once(
    frame: Frame, length: int, most: int
) -> None:
    one_by_one, at_once = bits_asked_for(frame, coasts=True)
    assert bits_asked_for(frame, coasts=False) == (one_by_one + at_once, 0)
    assert 0 < one_by_one <= most
    assert at_once > length // 2


@pytest.mark.parametrize("ppm", [-25_000, -12_000, 12_000, 25_000])
def test_a_clock_too_far_off_reads_the_same_wrong_bits(ppm: float) -> None:
    """Beyond what SJW makes good a sample slips into the sender's next bit, or the last one: no stretch goes so far."""
    seen = []
    for coasts in (True, False):
        with Lab() as lab:
            bus, a, b = pair(lab, ppm, coasts)
            a.send(FRAME)
            lab.run_until(5_000_000)
            seen.append((summary(lab, bus, [a, b]), a.counters, b.counters))
    assert seen[0] == seen[1]


def pair(lab: Lab, ppm: float, coasts: bool) -> tuple[LabBus, LabNode, LabNode]:
    bus = lab.can_bus(bit_rate=500_000, data_bit_rate=2_000_000)
    bus.wire.bits.coasts = coasts
    nodes = [bus.node("a"), bus.node("b", oscillator_ppm=ppm)]
    for node in nodes:
        node.events()
    return bus, nodes[0], nodes[1]


def bits_asked_for(frame: Frame, *, coasts: bool) -> tuple[int, int]:
    """How many bits of the frame were asked for one by one, and how many ahead."""
    asked: list[int] = []
    ahead: list[int] = []

    def ask(node: Node, index: int) -> int:
        asked.append(index)
        return -1

    def spare(node: Node, index: int, most: int) -> int:
        ahead.append(most)
        return most

    with Lab() as lab:
        bus, a, b = pair(lab, 100.0, coasts)
        bus.wire.bits.disturb, bus.wire.bits.spare = ask, spare
        a.send(frame)
        lab.run_until_idle()
        assert b.receive_many(2) == [frame]
    return len(asked), sum(ahead)


def outcome(seed: int, coasts: bool) -> dict[str, Any]:
    """What everybody saw in the scenario of this seed, and how things stood inside at some moments."""
    chance = random.Random(seed)
    fd = chance.random() < 0.5
    with Lab(seed=seed) as lab:
        timing = BitTiming.for_bit_rate(500_000, chance.choice([0.6, 0.8, 0.875]))
        data = BitTiming.for_bit_rate(chance.choice([500_000, 2_000_000, 4_000_000]), 0.75) if fd else None
        bus = lab.can_bus(timing=timing, data_timing=data)
        bus.wire.bitwise = chance.random() < 0.8
        bus.wire.bits.coasts = coasts
        nodes = [some_node(bus, k, chance) for k in range(chance.randrange(2, 5))]
        levels: list[tuple[int, int]] = []
        if bus.wire.bitwise and chance.random() < 0.5:
            bus.wire.bits.capture = lambda at_ps, level: levels.append((at_ps, level))
        for _ in range(chance.randrange(1, 20)):
            plan_a_frame(lab, nodes, chance, fd)
        if chance.random() < 0.5:
            disturb(lab, bus, nodes, chance)
        if chance.random() < 0.5:
            come_and_go(lab, bus, nodes, chance)
        seen = look_inside(lab, bus, nodes, random.Random(seed))
        lab.run_until(END_NS)
        bus.wire.bits.capture = None
        return {**summary(lab, bus, nodes), "levels": levels, "seen": seen}


def some_node(bus: LabBus, number: int, chance: random.Random) -> LabNode:
    listen_only = number > 1 and chance.random() < 0.2
    node = bus.node(f"n{number}", listen_only=listen_only, oscillator_ppm=chance.choice(PPM))
    node.events()
    if chance.random() < 0.3:
        start_with_counters(node, chance.randrange(256), chance.randrange(200))
    return node
