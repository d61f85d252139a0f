"""Whole frames in two steps, or bit by bit: the same frames, times, events and counters; and twice the same run."""

from __future__ import annotations

import random

import pytest

from canwire import Lab, LabLinNode, LinFrame, format_lin_log_line
from canwire.values.lin.text import LinLogLine

pytestmark = pytest.mark.core

SEEDS = 60


def told(node: LabLinNode) -> list[str]:
    """Everything a node heard and saw, in order."""
    messages = [*node.events(), *node.receive_many(10_000)]
    lines = [
        f"{message.timestamp_ns} {format_lin_log_line(LinLogLine(message.timestamp_ns, node.name, message))}"
        for message in messages
    ]
    return [*lines, str(node.counters)]


def something_happens(lab: Lab, nodes: list[LabLinNode], chance: random.Random, wild: bool) -> None:
    master, *slaves = nodes
    faults = master.bus.faults
    node = chance.choice(slaves)
    id = chance.randrange(6)
    data = chance.randbytes(chance.randrange(9))
    what = chance.randrange(12 if wild else 6)
    if what < 2:
        master.ask(id, chance.choice([0, 0, 2]))
    elif what == 2:
        master.send(LinFrame(id, data, enhanced=chance.random() < 0.5))
    elif what == 3:
        node.respond(id, data, once=chance.random() < 0.3)
    elif what == 4:
        node.withdraw(id)
    elif what == 5:
        node.subscribe(id, chance.randrange(9))
    elif what == 6:
        chance.choice([faults.checksum, faults.parity, faults.no_response, faults.short_break])()
    elif what == 7:
        node.stop()
    elif what == 8:
        node.start()
    elif what == 9:
        chance.choice([faults.cut, faults.stop_bit, faults.flip, faults.sync])()
    elif what == 10:
        master.sleep()
    elif node.state.name == "ASLEEP" and not node.line.busy:
        node.wake()


def run(seed: int, *, bitwise: bool, wild: bool) -> tuple[list[list[str]], int, float]:
    """A random script; times between its steps are random too, so that many fall into the middle of a frame."""
    chance = random.Random(seed)
    with Lab(seed=seed) as lab:
        bus = lab.lin_bus(bit_rate=chance.choice([1000, 9600, 19200, 20000]))
        bus.wire.bitwise = bitwise
        spaces = chance.choice([0, 0, 3, 40])
        nodes = [bus.master()]
        for k in range(chance.randrange(1, 4)):
            ppm = chance.choice([0.0, 0.0, 30_000.0, -100_000.0])
            nodes.append(bus.slave(f"s{k}", oscillator_ppm=ppm, response_space_bits=spaces))
        for node in nodes:
            node.events()
        for _ in range(60):
            something_happens(lab, nodes, chance, wild)
            lab.run_for(chance.choice([0.0, 0.0005, chance.random() / 300, 0.02]))
        lab.run_for(1.0)
        return [told(node) for node in nodes], bus.frames, bus.wire.busy_ns()


@pytest.mark.parametrize("seed", range(SEEDS))
@pytest.mark.parametrize("wild", [False, True])
def test_both_ways_tell_the_same(seed: int, wild: bool) -> None:
    quick, bit_by_bit = (run(seed, bitwise=bitwise, wild=wild) for bitwise in (False, True))
    assert quick[0] == bit_by_bit[0]
    assert quick[1] == bit_by_bit[1]
    assert quick[2] == pytest.approx(bit_by_bit[2], abs=100)


@pytest.mark.parametrize("seed", range(5))
def test_the_same_script_gives_the_same_bytes(seed: int) -> None:
    assert run(seed, bitwise=False, wild=True) == run(seed, bitwise=False, wild=True)
