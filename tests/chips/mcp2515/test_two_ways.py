"""Whole frames or bit by bit: every register of every MCP2515 must be the same at any moment.

Nobody who looks or acts interrupts the bus.
"""

from __future__ import annotations

import random

import pytest

from canwire.bus.can.faults.faults import Faults
from canwire.chips.mcp2515 import register_map as m
from canwire.chips.mcp2515.controller import Mcp2515
from tests.cases import each
from tests.chips.mcp2515.bench import BIT_NS, Bench
from tests.effort import seeds

pytestmark = pytest.mark.core

SEEDS_A_TEST = 10
ACTIONS, LOOKS = 30, 6
_ADDRESSES = [*range(128)]


@each("first", range(0, 40, SEEDS_A_TEST))
def test_both_ways_agree(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        assert outcome(seed, bitwise=False) == outcome(seed, bitwise=True), f"seed {seed}"


@pytest.mark.parametrize("first", range(0, 20, SEEDS_A_TEST))
def test_both_ways_agree_with_faults(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        one, other = (outcome(seed, bitwise=way, flips=True) for way in (False, True))
        assert one == other, f"seed {seed}"


def outcome(seed: int, *, bitwise: bool, flips: bool = False) -> list[str]:
    """What all registers hold at random moments, then the chips' interrupts in their order."""
    chance = random.Random(seed)
    bench = Bench(bitwise=bitwise)
    bus, timeline = bench.bus, bench.timeline
    told: list[tuple[int, int, int, int]] = []
    chips = []
    for number in range(chance.randrange(1, 5)):
        mode = m.LISTEN_ONLY if number > 1 and chance.random() < 0.2 else m.NORMAL
        chip = bench.chip(mode)
        chip.on_interrupt = lambda chip=chip, number=number: serve(chip, number, timeline.now_ns, told)
        chips.append(chip)
    if flips:
        seen_by = chance.choice(["all", "receivers", "sender"])
        Faults(bus, seed).flip(bit=chance.randrange(60), times=3, seen_by=seen_by)
    seen: list[str] = []
    for _ in range(ACTIONS):
        act(chips, chance)
        after_ns = chance.randrange(1, 300) * BIT_NS
        for _ in range(LOOKS):
            at_ns = timeline.now_ns + chance.randrange(after_ns)
            timeline.at(at_ns, lambda: seen.append(glance(timeline.now_ns, chips)))
        timeline.run_until(timeline.now_ns + after_ns + chance.randrange(BIT_NS))
    return [*seen, glance(timeline.now_ns, chips), repr(told)]


def glance(now_ns: int, chips: list[Mcp2515]) -> str:
    """Every register of every chip, and the time."""
    shown = [bytes(map(chip.peek, _ADDRESSES)).hex(" ") for chip in chips]
    return f"{now_ns}: " + " / ".join(shown)


def serve(chip: Mcp2515, number: int, now_ns: int, told: list[tuple[int, int, int, int]]) -> None:
    """An interrupt handler: note it, and clear every flag."""
    flags = chip.read(m.CANINTF)
    told.append((now_ns, number, flags, chip.read(m.EFLG)))
    chip.write(m.EFLG, 0)
    chip.write(m.CANINTF, 0)


def act(chips: list[Mcp2515], chance: random.Random) -> None:
    """Somebody's processor does something; identifiers end in the chip's number."""
    number = chance.randrange(len(chips))
    chip = chips[number]
    kind = chance.random()
    if kind < 0.7:
        buffer = chance.randrange(3)
        extended = m.SIDL_EXIDE if chance.random() < 0.3 else 0
        head = bytes((chance.choice([0x10, chance.randrange(256)]), number << 5 | extended, 0, 0))
        chip.load_buffer(buffer, head + bytes([chance.randrange(9)]) + chance.randbytes(8))
        chip.request_to_send(1 << buffer)
    elif kind < 0.8:
        chip.modify(m.CANCTRL, m.CTRL_OSM, chance.choice([0, m.CTRL_OSM]))
    elif kind < 0.88:
        chip.modify(m.TXBCTRL[chance.randrange(3)], m.TX_TXREQ, 0)
    elif kind < 0.92:
        chip.modify(m.CANCTRL, m.CTRL_ABAT, m.CTRL_ABAT)
        chip.modify(m.CANCTRL, m.CTRL_ABAT, 0)
    else:
        mode = chance.choice([m.CONFIGURATION, m.LISTEN_ONLY, m.NORMAL, m.NORMAL])
        chip.modify(m.CANCTRL, 0xE0, mode << m.REQOP_SHIFT)
