"""What happens on a bus in one random scenario: nodes, frames, starts and stops, disturbances. All by a seed.

Times are nanoseconds and whole quanta of 12.5 ns, but for looks, which fall between them.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field

from tests.bus.can.reference.frames import Heard
from tests.bus.can.reference.node import Order

STEP_NS = 25
BIT_NS = 2_000


@dataclass
class Member:
    """One node as it is at the beginning."""

    knows_fd: bool
    listen_only: bool
    tec: int
    rec: int


@dataclass
class Schedule:
    """The scenario; nodes go by their number, None is everybody."""

    members: list[Member]
    end_ns: int
    sends: list[tuple[int, int, Order]] = field(default_factory=list)
    stops: list[tuple[int, int, int]] = field(default_factory=list)  # from, to, node
    restarts: list[tuple[int, int]] = field(default_factory=list)
    flips: list[tuple[int, int, int | str]] = field(default_factory=list)  # bit, times, node or "all" ...
    holds: list[tuple[int, int, int, int | None]] = field(
        default_factory=list
    )  # at, bits, level, node or all
    glitches: list[tuple[int, int, int, int | None]] = field(
        default_factory=list
    )  # at, width, level, node or all
    shorts: list[tuple[int, int]] = field(default_factory=list)
    looks: list[int] = field(default_factory=list)


def schedule_of(
    seed: int, *, frames: int = 12, faults: int = 6, roles: bool = False, glitches: int = 0
) -> Schedule:
    """The scenario of this seed; about so many frames and disturbances.

    `roles`: what one node reads wrong is read so by the sender or by all receivers instead, half of the time.
    `glitches`: so many at most, most of them shorter than a bit, in place of levels held for whole bits and shorts.
    """
    chance = random.Random(seed)
    fd = chance.random() < 0.5
    members = [some_member(chance, k, fd) for k in range(chance.randrange(2, 5))]
    span_ns = frames * 250_000
    scenario = Schedule(members, span_ns + 1_500_000)
    for _ in range(frames):
        plan_a_send(scenario, chance, fd, span_ns)
    if faults:
        plan_disturbances(scenario, chance, faults, span_ns)
    if chance.random() < 0.3:
        node = chance.randrange(len(members))
        begin = moment(chance, span_ns)
        scenario.stops.append((begin, begin + moment(chance, span_ns // 2) + STEP_NS, node))
    for node in range(len(members)):
        scenario.restarts += [(moment(chance, scenario.end_ns), node) for _ in range(2)]
    scenario.looks = sorted(moment(chance, scenario.end_ns) + 7 for _ in range(40))
    if roles:
        scenario.flips = [
            (
                bit,
                times,
                viewer if viewer == "all" else chance.choice([viewer, viewer, "sender", "receivers"]),
            )
            for bit, times, viewer in scenario.flips
        ]
    if glitches:
        scenario.holds, scenario.shorts = [], []
        plan_glitches(scenario, chance, glitches, span_ns)
    return scenario


def moment(chance: random.Random, limit_ns: int) -> int:
    return chance.randrange(limit_ns // STEP_NS) * STEP_NS


def some_member(chance: random.Random, number: int, fd: bool) -> Member:
    knows_fd = fd and (number < 2 or chance.random() < 0.95)
    listen_only = number > 1 and chance.random() < 0.15
    worn = chance.random() < 0.4
    tec = chance.choice([0, 90, 120, 126, 130, 200, 240, 250]) if worn else 0
    rec = chance.choice([0, 90, 120, 127, 130, 250]) if worn else 0
    return Member(knows_fd, listen_only, tec, rec)


def plan_a_send(scenario: Schedule, chance: random.Random, fd: bool, span_ns: int) -> None:
    """Often several nodes send at about the same time."""
    at_ns = moment(chance, span_ns)
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        number = chance.randrange(len(scenario.members))
        member = scenario.members[number]
        if not member.listen_only:
            order = Order(some_frame(chance, number, fd and member.knows_fd), chance.random() < 0.15)
            scenario.sends.append((at_ns, number, order))
        at_ns += chance.choice([0, 0, STEP_NS, 1_500, BIT_NS, chance.randrange(400) * STEP_NS])


def some_frame(chance: random.Random, number: int, fd: bool) -> Heard:
    """Its identifier ends in the node's number, so that no two nodes' are equal."""
    extended = chance.random() < 0.4
    is_fd = fd and chance.random() < 0.6
    remote = not is_fd and chance.random() < 0.15
    id = chance.choice(
        [chance.randrange(1 << (26 if extended else 8)), 0, (1 << (26 if extended else 8)) - 1]
    )
    id = id * 8 + number
    length = chance.choice([0, 1, 2, 8, 12, 20, 64]) if is_fd else chance.randrange(9)
    dlc = length if length <= 8 else [12, 16, 20, 24, 32, 48, 64].index(length) + 9
    if not is_fd and length == 8:
        dlc = chance.choice([8, 8, 9, 15])
    data = b"" if remote else chance.choice([chance.randbytes(length), bytes(length), b"\xff" * length])
    switch = is_fd and chance.random() < 0.8
    return Heard(id, extended, remote, is_fd, switch, False, dlc, data)


def plan_disturbances(scenario: Schedule, chance: random.Random, count: int, span_ns: int) -> None:
    """Flips, and either levels held in front of receivers or shorts."""
    shorts = chance.random() < 0.3
    at_ns = 0
    for _ in range(chance.randrange(count + 1)):
        node = chance.choice([None, *range(len(scenario.members))])
        if chance.random() < 0.5:
            viewer = "all" if node is None else node
            scenario.flips.append((chance.randrange(140), chance.choice([1, 1, 2, 20]), viewer))
            continue
        at_ns += STEP_NS + moment(chance, max(STEP_NS, 2 * span_ns // count))
        bits = chance.choice([1, 1, 1, 2, 3, 6, 8, 14, 20, 40])
        if shorts:
            scenario.shorts.append((at_ns, at_ns + bits * BIT_NS))
        else:
            scenario.holds.append((at_ns, bits, chance.randrange(2), node))
        at_ns += bits * BIT_NS


def plan_glitches(scenario: Schedule, chance: random.Random, count: int, span_ns: int) -> None:
    """One behind the other; often two or three within the same bit."""
    at_ns = 0
    for _ in range(chance.randrange(count + 1)):
        gap_ns = chance.choice([BIT_NS, BIT_NS, 8 * BIT_NS, max(BIT_NS, 4 * span_ns // count)])
        at_ns += STEP_NS + moment(chance, gap_ns)
        width_ns = STEP_NS + moment(chance, chance.choice([100, 500, BIT_NS, 2 * BIT_NS]))
        node = chance.choice([None, *range(len(scenario.members))])
        scenario.glitches.append((at_ns, width_ns, chance.choice([0, 0, 1]), node))
        at_ns += width_ns
