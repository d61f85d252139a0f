"""The bus skips over undisturbed frames in one step, or goes bit by bit: nobody may see a difference.

Random scenarios run both ways; records, counters, events and busy time must agree to the last byte, at the end and at
random moments in the middle of frames. Looking must not take the bus out of its way.
"""

from __future__ import annotations

import random
from typing import Any

import pytest

from canwire import ControllerOptions, DelayCompensation, Frame, Lab, LabBus, LabNode
from tests.effort import seeds

pytestmark = pytest.mark.core

SEEDS = 150
SEEDS_A_TEST = 10
SPAN_NS = 5_000_000
END_NS = 12_000_000
LOOKS = 150


@pytest.mark.conforms("G-06", "G-09")
@pytest.mark.parametrize("first", range(0, SEEDS, SEEDS_A_TEST))
def test_both_ways_agree(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        assert outcome(seed, bitwise=False) == outcome(seed, bitwise=True), f"seed {seed}"


@pytest.mark.parametrize("first", range(0, 40, SEEDS_A_TEST))
def test_switching_between_the_ways_at_any_moment_agrees_too(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        assert outcome(seed, bitwise=False) == outcome(seed, bitwise=None), f"seed {seed}"


@pytest.mark.parametrize("first", range(0, 40, SEEDS_A_TEST))
def test_faults_hit_the_same_bits_either_way(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        one, other = (outcome(seed, bitwise=bitwise, flips=True) for bitwise in (False, True))
        assert one == other, f"seed {seed}"


@pytest.mark.parametrize("first", range(0, 40, SEEDS_A_TEST))
def test_noise_hits_the_same_bits_either_way(first: int) -> None:
    """With the same seed: a trace of the levels, which makes the bus go bit by bit, must change nothing."""
    for seed in seeds(first, SEEDS_A_TEST):
        one, other = (outcome(seed, bitwise=bitwise, noise=3e-4) for bitwise in (False, True))
        assert one == other, f"seed {seed}"


@pytest.mark.parametrize("first", range(0, 60, SEEDS_A_TEST))
def test_controllers_with_options_agree_too(first: int) -> None:
    """Loop delays, compensated or not; second sample points at bad places; tolerant and restricted controllers."""
    for seed in seeds(first, SEEDS_A_TEST):
        one, other = (outcome(seed, bitwise=bitwise, options=True) for bitwise in (False, True))
        assert one == other, f"seed {seed}"


def outcome(
    seed: int, *, bitwise: bool | None, flips: bool = False, noise: float = 0.0, options: bool = False
) -> dict[str, Any]:
    """What everybody saw in the scenario of this seed; None changes the way again and again."""
    chance = random.Random(seed)
    fd = chance.random() < 0.4
    with Lab(seed=seed) as lab:
        bus = lab.can_bus(
            bit_rate=chance.choice([125_000, 250_000, 500_000, 1_000_000]),
            data_bit_rate=chance.choice([1_000_000, 2_000_000, 4_000_000]) if fd else None,
            iso_fd=chance.random() < 0.8,
        )
        nodes = some_nodes(bus, chance) if not options else nodes_with_options(bus, chance)
        if bitwise is None:
            keep_changing(lab, bus, random.Random(seed))
        else:
            bus.wire.bitwise = bitwise
        bus.faults.noise(noise)
        if flips:
            seen_by = chance.choice(["all", "receivers", "sender", nodes[-1]])
            bus.faults.flip(bit=chance.randrange(80), times=3, seen_by=seen_by)
        for _ in range(chance.randrange(1, 30)):
            plan_a_frame(lab, nodes, chance, fd)
        for node in nodes:
            if chance.random() < 0.3:
                start_with_counters(node, chance.randrange(200), chance.randrange(200))
        if chance.random() < 0.3 and len(nodes) > 1:
            lab.at(chance.randrange(SPAN_NS), nodes[-1].stop)
            lab.at(SPAN_NS + chance.randrange(1_000_000), nodes[-1].start)
        seen = look_at_random_moments(lab, bus, nodes, random.Random(seed))
        lab.run_until(END_NS)
        return {**summary(lab, bus, nodes), "seen": seen}


def some_nodes(bus: LabBus, chance: random.Random) -> list[LabNode]:
    nodes = []
    for k in range(chance.randrange(1, 6)):
        self_reception = chance.random() < 0.2
        listen_only = k > 1 and chance.random() < 0.2
        nodes.append(bus.node(f"n{k}", self_reception=self_reception, listen_only=listen_only))
        nodes[-1].events()
    return nodes


def nodes_with_options(bus: LabBus, chance: random.Random) -> list[LabNode]:
    """The first two can send; nobody's loop delay is that long that classic frames fail."""
    nodes = []
    for k in range(chance.randrange(2, 6)):
        fd = k < 2 or chance.random() < 0.7
        options = random_options(chance, restricted=k > 1 and chance.random() < 0.3)
        nodes.append(bus.node(f"n{k}", fd=fd, options=options))
        nodes[-1].events()
    return nodes


def random_options(chance: random.Random, *, restricted: bool) -> ControllerOptions:
    compensation = None
    if chance.random() < 0.6:
        offset_ns = chance.choice([100, 190, 350, 700])
        filter_ns = chance.choice([0, 0, 150, 400])
        measured = chance.random() < 0.7
        compensation = DelayCompensation(offset_ns, filter_ns if measured else 0, measured)
    exception = chance.random() < 0.8
    return ControllerOptions(
        chance.choice([0, 0, 50, 120, 190, 200, 450]),
        compensation,
        edge_filter=chance.random() < 0.3,
        restricted=restricted,
        protocol_exception=exception,
        fd_tolerant=exception and chance.random() < 0.7,
    )


def plan_a_frame(
    lab: Lab, nodes: list[LabNode], chance: random.Random, fd: bool, *, span_ns: int = SPAN_NS
) -> None:
    """A frame of one of the nodes at some time; its identifier ends in the node's number."""
    at_ns = chance.randrange(span_ns)
    number = chance.randrange(len(nodes))
    node = nodes[number]
    frame = random_frame(chance, number, fd and node.settings.data_timing is not None)
    single_shot, high_priority = chance.random() < 0.15, chance.random() < 0.15
    if not (node.settings.listen_only or node.settings.options.restricted):
        lab.at(at_ns, lambda: node.send(frame, single_shot=single_shot, high_priority=high_priority))


def random_frame(chance: random.Random, number: int, fd: bool) -> Frame:
    extended = chance.random() < 0.4
    is_fd = fd and chance.random() < 0.6
    remote = not is_fd and chance.random() < 0.1
    id = chance.randrange(1 << (26 if extended else 8)) * 8 + number
    if remote:
        return Frame(id, extended=extended, remote=True, dlc=chance.randrange(9))
    length = chance.choice([0, 1, 8, 12, 16, 20, 64]) if is_fd else chance.randrange(9)
    data = chance.randbytes(length) if chance.random() < 0.7 else bytes([chance.choice([0, 255])]) * length
    return Frame(id, data, extended=extended, fd=is_fd, bit_rate_switch=is_fd and chance.random() < 0.7)


def start_with_counters(node: LabNode, tec: int, rec: int) -> None:
    """As if the node had had errors before."""
    controller = node.line.controller
    controller.confinement.tec, controller.confinement.rec = tec, rec
    controller.confinement.apply(0)
    controller.passive = controller.confinement.state >= 2
    controller.tainted = rec > 0


def keep_changing(lab: Lab, bus: LabBus, chance: random.Random) -> None:
    for at_ns in range(0, END_NS, 400_000):
        lab.at(at_ns + chance.randrange(400_000), lambda: change_way(bus), background=True)


def change_way(bus: LabBus) -> None:
    bus.wire.bitwise = not bus.wire.bitwise


def look_at_random_moments(
    lab: Lab,
    bus: LabBus,
    nodes: list[LabNode],
    chance: random.Random,
    *,
    looks: int = LOOKS,
    end_ns: int = END_NS // 2,
) -> list[dict[str, Any]]:
    """What everybody sees at some hundred moments, which comes into the list as time goes on."""
    seen: list[dict[str, Any]] = []

    def look() -> None:
        glance = summary(lab, bus, nodes)
        for node in nodes:
            controller = node.line.controller
            wire = controller.bus  # a stub of its own while its plug is out
            glance[node.name] = (wire.on_wire(controller), wire.activity(controller))
        seen.append(glance)

    for _ in range(looks):
        lab.at(chance.randrange(end_ns), look, background=True)
    return seen


def summary(lab: Lab, bus: LabBus, nodes: list[LabNode]) -> dict[str, Any]:
    told: dict[str, Any] = {
        "bus": (lab.now_ns, bus.frames, bus.error_frames, bus.wire.busy_ns(), bus.load, bus.mean_load)
    }
    for node in nodes:
        told[f"{node.name} received"] = node.receive_array().tobytes()
        told[f"{node.name} counters"] = (
            node.counters, node.sent, node.delivered, node.aborted, node.pending,
            node.accepted, node.lost, node.arbitration_losses,
        )  # fmt: skip
        told[f"{node.name} events"] = node.events()
    return told
