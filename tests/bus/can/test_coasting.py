"""Many bits in one step, or each bit in two: nobody may see a difference, nor may anything inside be different.

Random scenarios run both ways, whole frames switched off: nodes of all roles, worn counters, clocks that drift, cables,
noise, faults, levels forced by time and place, starts, stops and plugs in the midst of frames. Looks at random moments
compare what nodes show, and every station and clock below them.
"""

from __future__ import annotations

import random
from typing import Any

import pytest

from canwire import BitTiming, Frame, Lab, LabBus, LabNode
from canwire.bus.can.node import QUIET, SENDING, Node
from tests.bus.can.test_two_ways import (
    plan_a_frame,
    random_options,
    start_with_counters,
    summary,
)
from tests.effort import seeds

pytestmark = pytest.mark.core

SEEDS_A_TEST = 15
SPAN_NS = 4_000_000
END_NS = 8_000_000
LOOKS = 60
STATION = (
    "state", "out", "last_sample", "rate_change", "index", "run", "left", "dominant_run", "flag_level", "fast",
    "sof_seen", "transmitting", "finished", "rejoined", "overload", "tec_due", "just_free", "flagged", "counted",
    "acknowledging", "acknowledged", "second_ack", "now_ns", "sof_ns",
)  # fmt: skip
READER = (
    "field", "left", "value", "same", "last", "stuffing", "stuff_count", "crc15", "crc17", "crc21", "crc_ok",
    "identifier", "extended", "remote", "fd", "dlc",
)  # fmt: skip
CLOCK = ("start_ps", "due_ps", "sampling", "synchronised", "joins", "data_rate", "edge_ps", "check_ps")


@pytest.mark.conforms("G-09")
@pytest.mark.parametrize("first", range(0, 150, SEEDS_A_TEST))
def test_many_bits_at_once_are_those_bits(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        one, other = (outcome(seed, coasts=coasts) for coasts in (True, False))
        assert one == other, f"seed {seed}"


@pytest.mark.parametrize("first", range(1000, 1060, SEEDS_A_TEST))
def test_so_are_they_when_whole_frames_are_stepped_over_between_them(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        one, other = (outcome(seed, coasts=coasts, bitwise=False) for coasts in (True, False))
        assert one == other, f"seed {seed}"


@pytest.mark.parametrize("first", range(2000, 2060, SEEDS_A_TEST))
def test_so_are_they_where_clocks_disagree_or_nodes_have_options(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        one, other = (outcome(seed, coasts=coasts, alike=False) for coasts in (True, False))
        assert one == other, f"seed {seed}"


def test_all_bits_of_a_good_frame_are_taken_at_once() -> None:
    """Else the tests above would compare a way with itself."""
    assert bits_asked_for(coasts=False) == (62, 0)
    assert bits_asked_for(coasts=True) == (0, 62)


@pytest.mark.parametrize("coasts", [True, False])
def test_what_interrupts_a_frame_at_the_beginning_of_time_finds_it_there(coasts: bool) -> None:
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000)
        bus.wire.bits.coasts = coasts
        nodes = [bus.node(f"n{k}") for k in range(3)]
        nodes[0].send(Frame(0x123, b"\x11\x22"))
        lab.run_until(0)
        nodes[2].stop()
        assert bus.wire.activity(nodes[0].line.controller) in (QUIET, SENDING)
        assert bus.frames == 0
        lab.run_until_idle()
        assert nodes[1].receive_many(2)[0].timestamp_ns == 62 * 2000
        assert nodes[2].receive_many(2) == []


@pytest.mark.parametrize("extended", [False, True])
@pytest.mark.parametrize("exception", [False, True])
def test_a_classic_controller_left_with_an_fd_frame_goes_the_same_way(
    extended: bool, exception: bool
) -> None:
    """It cannot read its own frame; whatever comes of that."""
    seen = []
    for coasts in (True, False):
        with Lab() as lab:
            bus = lab.can_bus(bit_rate=500_000, data_bit_rate=2_000_000)
            bus.wire.bitwise = True
            bus.wire.bits.coasts = coasts
            nodes = [bus.node(f"n{k}") for k in range(3)]
            for node in nodes:
                node.events()
            nodes[1].send(Frame(0x50))
            nodes[0].send(Frame(0x123, bytes(range(16)), fd=True, bit_rate_switch=True, extended=extended))
            lab.run_until(10_000)
            controller = nodes[0].line.controller
            controller.fd, controller.protocol_exception = 0, exception
            lab.run_until(5_000_000)
            seen.append(summary(lab, bus, nodes))
    assert seen[0] == seen[1]


def bits_asked_for(*, coasts: bool) -> tuple[int, int]:
    """How many bits of a frame were asked for one by one, and how many ahead."""
    asked: list[int] = []
    ahead: list[int] = []

    def disturb(node: Node, index: int) -> int:
        asked.append(index)
        return -1

    def spare(node: Node, index: int, most: int) -> int:
        ahead.append(most)
        return most

    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000)
        nodes = [bus.node(f"n{k}") for k in range(3)]
        bus.wire.bitwise = True
        bits = bus.wire.bits
        bits.coasts, bits.disturb, bits.spare = coasts, disturb, spare
        nodes[0].send(Frame(0x123, b"\x11\x22"))
        lab.run_until_idle()
        assert bus.frames == 1
    return len(asked), sum(ahead)


def outcome(seed: int, *, coasts: bool, bitwise: bool = True, alike: bool = True) -> dict[str, Any]:
    """What everybody saw in the scenario of this seed, and how things stood inside at some moments."""
    chance = random.Random(seed)
    fd = chance.random() < 0.4
    with Lab(seed=seed) as lab:
        bus = lab.can_bus(
            bit_rate=chance.choice([250_000, 500_000, 1_000_000]),
            data_bit_rate=chance.choice([2_000_000, 4_000_000]) if fd else None,
            iso_fd=chance.random() < 0.8,
            length_m=0.0 if alike else chance.choice([0.0, 10.0]),
        )
        bus.wire.bitwise = bitwise
        bus.wire.bits.coasts = coasts
        nodes = [some_node(bus, k, chance, alike=alike) for k in range(chance.randrange(2, 6))]
        levels: list[tuple[int, int]] = []
        if bitwise and chance.random() < 0.5:
            bus.wire.bits.capture = lambda at_ps, level: levels.append((at_ps, level))
        for _ in range(chance.randrange(1, 20)):
            plan_a_frame(lab, nodes, chance, fd)
        disturb(lab, bus, nodes, chance)
        come_and_go(lab, bus, nodes, chance)
        seen = look_inside(lab, bus, nodes, random.Random(seed))
        lab.run_until(END_NS)
        bus.wire.bits.capture = None
        return {**summary(lab, bus, nodes), "levels": levels, "seen": seen}


def some_node(bus: LabBus, number: int, chance: random.Random, *, alike: bool) -> LabNode:
    listen_only = number > 1 and chance.random() < 0.15
    if alike:
        node = bus.node(f"n{number}", listen_only=listen_only, fd=number < 2 or chance.random() < 0.8)
    elif chance.random() < 0.3:
        rate = chance.choice([125_000, 800_000])
        node = bus.node(f"n{number}", timing=BitTiming.for_bit_rate(rate, clock_hz=80_000_000))
    else:
        options = random_options(chance, restricted=number > 1 and not listen_only and chance.random() < 0.2)
        drift = chance.choice([0.0, 0.0, 40.0, -900.0])
        node = bus.node(f"n{number}", listen_only=listen_only, oscillator_ppm=drift, options=options)
    node.events()
    if chance.random() < 0.3:
        start_with_counters(node, chance.randrange(256), chance.randrange(200))
    return node


def disturb(lab: Lab, bus: LabBus, nodes: list[LabNode], chance: random.Random) -> None:
    faults = bus.faults
    faults.noise(chance.choice([0.0, 1e-3, 1e-2]))
    for _ in range(chance.randrange(3)):
        seen_by = chance.choice(["all", "receivers", "sender", *nodes])
        faults.flip(bit=chance.randrange(100), times=chance.choice([1, 5]), seen_by=seen_by)
    for _ in range(chance.randrange(3)):
        level, seen_by = chance.choice(["dominant", "recessive"]), chance.choice(["all", *nodes])
        faults.glitch(
            level, at=chance.randrange(SPAN_NS), width_ns=chance.choice([100, 900, 9000]), seen_by=seen_by
        )
    if chance.random() < 0.3:
        part = chance.choice(["error flag", "error delimiter", "intermission", "suspend"])
        faults.hold("dominant", at=faults.place(part, 2), bits=1, seen_by=chance.choice(["all", nodes[0]]))
    if chance.random() < 0.2:
        begin = chance.randrange(SPAN_NS)
        lab.at(begin, faults.short)
        lab.at(begin + chance.randrange(100_000), faults.clear_short)


def come_and_go(lab: Lab, bus: LabBus, nodes: list[LabNode], chance: random.Random) -> None:
    """Some stop and start, recover, or lose their plug, at any moment of a frame."""
    if chance.random() < 0.4:
        lab.at(chance.randrange(SPAN_NS), nodes[-1].stop)
        lab.at(SPAN_NS + chance.randrange(1_000_000), nodes[-1].start)
    for node in nodes:
        lab.at(chance.randrange(END_NS), node.restart)
    if chance.random() < 0.3:
        controller = nodes[0].line.controller
        begin = chance.randrange(SPAN_NS)
        lab.at(begin, lambda: bus.wire.detach(controller))
        lab.at(begin + chance.randrange(500_000), lambda: plug_in(lab, bus, nodes[0]))


def plug_in(lab: Lab, bus: LabBus, node: LabNode) -> None:
    controller = node.line.controller
    bus.wire.attach(controller)
    controller.rejoin(lab.now_ns)


def look_inside(lab: Lab, bus: LabBus, nodes: list[LabNode], chance: random.Random) -> list[Any]:
    seen: list[Any] = []

    def look() -> None:
        bits = bus.wire.bits
        inside = [
            (
                [getattr(clock, name) for name in CLOCK],
                [getattr(clock.station, name) for name in STATION],
                [getattr(clock.station.reader, name) for name in READER],
                [clock.echo.level_at(bits.now_ps - back) for back in (0, 1, 3_000_000)],
            )
            for clock in bits.clocks
        ]
        doing = [
            (bus.wire.on_wire(node.line.controller), bus.wire.activity(node.line.controller))
            for node in nodes
        ]
        seen.append((lab.now_ns, bits.now_ps, inside, doing, summary(lab, bus, nodes)))

    for _ in range(LOOKS):
        lab.at(chance.randrange(END_NS * 3 // 4), look, background=True)
    return seen
