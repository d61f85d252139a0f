"""Whole frames or bit by bit, compiled or interpreted: every register of every SJA1000 must be the same at any moment.

Nobody who looks or acts interrupts the bus.
"""

from __future__ import annotations

import hashlib
import importlib
import random
from types import ModuleType
from typing import Any

import pytest

import canwire
from tests.cases import each
from tests.effort import seeds
from tests.uncompiled import load_uncompiled

pytestmark = pytest.mark.core

BIT_NS = 2_000
SEEDS_A_TEST = 10
ACTIONS, LOOKS = 40, 6
BTR1 = (0x1C, 0x1C, 0x3A, 0x9C, 0xC9)  # 16 quanta all of them, sampled at 69 to 87.5 %, once or thrice


@each("first", range(0, 60, SEEDS_A_TEST))
def test_both_ways_agree(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        assert outcome(canwire, seed, bitwise=False) == outcome(canwire, seed, bitwise=True), f"seed {seed}"


@pytest.mark.parametrize("first", range(0, 20, SEEDS_A_TEST))
def test_both_ways_agree_with_faults(first: int) -> None:
    for seed in seeds(first, SEEDS_A_TEST):
        one, other = (outcome(canwire, seed, bitwise=way, flips=True) for way in (False, True))
        assert one == other, f"seed {seed}"


@each("seed", range(4))
def test_both_forms_agree(seed: int) -> None:
    here = outcome(canwire, seed, bitwise=False, flips=True)
    with load_uncompiled(canwire) as twin:
        assert outcome(twin, seed, bitwise=False, flips=True) == here


def outcome(package: ModuleType, seed: int, *, bitwise: bool, flips: bool = False) -> tuple[str, list[str]]:
    """What all chips' registers hold at the end, and their interrupts in their order."""
    chance = random.Random(seed)
    bus, chips, told = scene(package, chance, bitwise)
    timeline = bus.timeline
    if flips:
        faults = importlib.import_module(f"{package.__name__}.bus.can.faults.faults").Faults(bus, seed)
        faults.flip(bit=chance.randrange(60), times=3, seen_by=chance.choice(["all", "receivers", "sender"]))
    whole = hashlib.sha256()
    seen: list[str] = []
    for _ in range(ACTIONS):
        act(chips, chance)
        after_ns = chance.randrange(1, 400) * BIT_NS
        for _ in range(LOOKS):
            timeline.at(
                timeline.now_ns + chance.randrange(after_ns), lambda: seen.append(glance(timeline, chips))
            )
        timeline.run_until(timeline.now_ns + after_ns + chance.randrange(BIT_NS))
    timeline.run_until(timeline.now_ns + 4000 * BIT_NS)
    for chip in chips:
        chip.write(1, 2)  # nothing repeats itself for ever
    timeline.run_until(timeline.now_ns + 400 * BIT_NS)
    shown = [*seen, glance(timeline, chips), *(repr(calls) for calls in told)]
    whole.update(repr((shown, bus.tally.frames, bus.tally.error_frames)).encode())
    return whole.hexdigest(), shown


def glance(timeline: Any, chips: list[Any]) -> str:
    """Every register of every chip, read without side effects, and the time."""
    shown = [bytes(map(chip.peek, range(128))).hex(" ") for chip in chips]
    return f"{timeline.now_ns}: " + " / ".join(shown)


def scene(package: ModuleType, chance: random.Random, bitwise: bool) -> tuple[Any, list[Any], list[Any]]:
    can_bus, timeline, model = (
        importlib.import_module(f"{package.__name__}.{name}")
        for name in ("bus.can.bus", "timeline", "chips.sja1000.controller")
    )
    bus = can_bus.CanBus(timeline.Timeline())
    bus.bitwise = bitwise
    told: list[Any] = [[] for _ in range(5)]
    chips = []
    for number in range(chance.randrange(2, 5)):
        chip = model.Sja1000(bus)
        chip.write(6, 0x00)
        chip.write(7, chance.choice(BTR1))
        chip.write(31, 0x80)
        chip.write(4, chance.randrange(256))
        for k in range(4):
            chip.write(20 + k, 0xFF)
        chip.on_interrupt = lambda chip=chip, number=number: told[number].append(
            (bus.timeline.now_ns, chip.read(3), chip.read(11), chip.read(12))
        )
        chip.write(0, chance.choice([0x08, 0x08, 0x08, 0x0C, 0x0A if number > 1 else 0x08]))
        chips.append(chip)
    bus.timeline.run_until(20 * BIT_NS)
    return bus, chips, told


def act(chips: list[Any], chance: random.Random) -> None:
    """Somebody's processor does something; identifiers end in the chip's number."""
    number = chance.randrange(len(chips))
    chip = chips[number]
    kind = chance.random()
    if kind < 0.6:
        extended, length = chance.random() < 0.3, chance.randrange(9)
        chip.write(16, length | (0x80 if extended else 0) | (0x40 if chance.random() < 0.1 else 0))
        chip.write(17, chance.choice([0x10, chance.randrange(256)]))
        for k in range(18, 29):
            chip.write(k, chance.randrange(256))
        chip.write(20 if extended else 18, number << 5)
        chip.write(1, chance.choice([0x01, 0x01, 0x03, 0x10, 0x12]))
    elif kind < 0.8:
        chip.write(1, 0x0C)
    elif kind < 0.85:
        chip.write(0, 0x10)
    elif kind < 0.9:
        chip.write(0, 0x01)
        chip.write(15, chance.choice([0, 100, 120, 250, 255]))
        chip.write(14, chance.choice([0, 90, 130]))
        chip.write(0, 0x08)
        chip.write(0, 0x08)
    else:
        chip.read(11)
        chip.read(12)
        chip.read(3)
