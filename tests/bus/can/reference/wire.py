"""The wire and every node's bit time, in quanta that all nodes share: boundaries, then edges, then samples.

An idle node's own SOF begins when it has something to send, not at a bit boundary: quanta later would be the same,
whole bits would not. A flip is a bit sampled wrong, an edge is what stands in front of the receiver.

Source: ISO 11898-1:2015 11.3; reference/can-protocol.md section 8.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from typing import NamedTuple

from tests.bus.can.reference.frames import DOMINANT, NEXT_BIT, RECESSIVE, Bits
from tests.bus.can.reference.node import Node

NEVER = 1 << 62


class Rate(NamedTuple):
    """One bit time in quanta."""

    bit: int
    sample: int
    jump: int


NOMINAL = Rate(160, 140, 20)  # 500 kbit/s at 80 MHz, sampled at 87.5 %
DATA = Rate(40, 32, 8)  # 2 Mbit/s at 80 %


class Clock:
    """One node's bit time."""

    def __init__(self, node: Node, now: int, groups: int) -> None:
        self.node = node
        self.begin_life(now, groups)

    def begin_life(self, now: int, groups: int) -> None:
        """Its first bit begins now."""
        self.rate = NOMINAL
        self.start = self.due = now
        self.sampling = False
        self.synchronised = False
        self.dominant = False  # was this bit, or what came right before it
        self.last_sample = RECESSIVE
        self.seen = RECESSIVE
        self.out = RECESSIVE
        self.node.now = now
        self.node.pending_rate = False
        self.node.after_this_bit.clear()
        self.node.just_free = False
        self.machine: Bits = self.node.life(groups)
        assert next(self.machine) == NEXT_BIT

    def boundary(self, now: int) -> None:
        self.start, self.sampling = now, True
        self.due = now + self.rate.sample
        self.node.level_before = self.seen
        self.dominant = self.seen == DOMINANT
        self.out = self.machine.send(RECESSIVE)
        self.node.sof_edge = False

    def sample(self, now: int, level: int) -> None:
        self.last_sample, self.sampling, self.synchronised = level, False, False
        self.node.sof_edge = False
        assert self.machine.send(level) == NEXT_BIT
        self.rate = DATA if self.node.pending_rate else NOMINAL
        self.due = now + self.rate.bit - self.rate.sample

    def edge(self, now: int) -> None:
        """Recessive to dominant: one synchronisation between two samples, behind a recessive one."""
        node = self.node
        self.dominant = True
        if node.where == "integrating":
            node.recessive = 0
            self.hard(now)
        elif self.synchronised or self.last_sample == DOMINANT:
            return
        elif node.where in ("idle", "suspend", "intermission 2", "intermission 3", "res"):
            node.sof_edge = True
            self.hard(now)
        elif not (node.transmitting and self.rate is DATA):
            self.resynchronise(now)

    def hard(self, now: int) -> None:
        self.synchronised = True
        if self.sampling:
            self.start, self.due = now, now + self.rate.sample
        else:
            self.due = now

    def resynchronise(self, now: int) -> None:
        if self.sampling:
            late = now - self.start
            if late and self.out == DOMINANT:
                return
            self.due += min(late, self.rate.jump)
        else:
            self.due -= min(self.due - now, self.rate.jump)
        self.synchronised = True

    def request(self, now: int) -> None:
        """There is something to send: an idle bit is cut short for it, unless an edge has set this clock."""
        if self.node.where == "idle" and not self.dominant and self.start != now:
            if self.sampling:  # the idle bit is cut short
                self.machine.send(RECESSIVE)
            self.due, self.sampling = now, False


class Flip(NamedTuple):
    """Bit `index` of the frames on the wire is sampled wrong by "all", "sender", "receivers" or one node."""

    index: int
    times: list[int]
    seen_by: str | Node


class Hold(NamedTuple):
    """A level in front of some receivers; on the wire itself if `everybody`."""

    begins: int
    ends: int
    level: int
    nodes: list[Node]
    everybody: bool


class Wire:
    """A wired AND of clocks; `levels` is its trace."""

    def __init__(self) -> None:
        self.now = 0
        self.clocks: list[Clock] = []
        self.flips: list[Flip] = []
        self.flip: Flip | None = None
        self.driver: Clock | None = None  # whose bit is inverted
        self.chosen: Flip | None = None
        self.flips_for: tuple[Node | None, int] = (None, 0)
        self.holds: list[Hold] = []
        self.shorted = False
        self.levels = [(0, RECESSIVE)]
        self.actions: list[tuple[int, int, Callable[[], None]]] = []

    def at(self, time: int, action: Callable[[], None]) -> None:
        heapq.heappush(self.actions, (time, len(self.actions), action))

    def clock_of(self, node: Node) -> Clock | None:
        return next((clock for clock in self.clocks if clock.node is node), None)

    def start(self, node: Node, groups: int) -> None:
        """From now on this node lives here, behind so many groups of recessive bits."""
        self.stop(node)
        self.clocks.append(Clock(node, self.now, groups))

    def stop(self, node: Node) -> None:
        self.clocks = [clock for clock in self.clocks if clock.node is not node]

    def run_until(self, limit: int) -> None:
        while True:
            soonest = min([clock.due for clock in self.clocks], default=NEVER)
            if self.actions:
                soonest = min(soonest, self.actions[0][0])
            for hold in self.holds:
                soonest = min(soonest, *(time for time in hold[:2] if time > self.now), NEVER)
            if soonest > limit:
                self.now = limit
                return
            self.now = soonest
            self.instant()

    def instant(self) -> None:
        """All that happens now."""
        now = self.now
        while self.actions and self.actions[0][0] <= now:
            heapq.heappop(self.actions)[2]()
        for clock in self.clocks:
            clock.node.now = now
        beginning = [clock for clock in self.clocks if clock.due == now and not clock.sampling]
        for clock in beginning:
            clock.boundary(now)
        if beginning:
            self.choose_flip(beginning)
        self.look()
        for clock in [clock for clock in self.clocks if clock.due == now and clock.sampling]:
            clock.sample(now, self.read_by(clock))

    def look(self) -> None:
        """The levels, the trace, and edges."""
        self.holds = [hold for hold in self.holds if hold.ends > self.now]
        wire = DOMINANT if self.shorted else min([clock.out for clock in self.clocks], default=RECESSIVE)
        shown = wire
        if self.flip is not None and self.flip.seen_by == "all":
            shown = 1 - wire
        for hold in self.holds:
            if hold.everybody and hold.begins <= self.now:
                shown = hold.level
        if shown != self.levels[-1][1]:
            self.levels.append((self.now, shown))
        for clock in self.clocks:
            level = self.in_front_of(clock, wire)
            fell = clock.seen == RECESSIVE and level == DOMINANT
            clock.seen = level
            if fell:
                clock.edge(self.now)

    def in_front_of(self, clock: Clock, wire: int) -> int:
        level = wire
        for hold in self.holds:
            if hold.begins <= self.now and (hold.everybody or clock.node in hold.nodes):
                level = hold.level
        return level

    def read_by(self, clock: Clock) -> int:
        flip = self.flip
        held = any(
            hold.begins <= self.now and (hold.everybody or clock.node in hold.nodes) for hold in self.holds
        )
        if flip is None or self.shorted or held:
            return clock.seen
        wrong = {"all": True, "sender": clock is self.driver, "receivers": clock is not self.driver}
        return 1 - clock.seen if wrong.get(flip.seen_by, clock.node is flip.seen_by) else clock.seen

    def choose_flip(self, beginning: list[Clock]) -> None:
        """A sender's bit begins: is it to be read wrong? Each frame meets the first flip that it has a bit for."""
        senders = [clock for clock in self.clocks if clock.node.transmitting and clock.node.where == "frame"]
        if not senders:
            if self.driver in beginning or self.driver not in self.clocks:
                self.flip = None
            return
        first = min(senders, key=lambda clock: clock.node.arbitration)
        if first in beginning:
            self.driver = first
            node = first.node
            if (node, node.sof_at) != self.flips_for:
                self.flips_for = (node, node.sof_at)
                chosen = [flip for flip in self.flips if flip.times[0] and flip.index < len(node.levels)]
                self.chosen = chosen[0] if chosen else None
            self.flip = self.chosen if self.chosen is not None and self.chosen.index == node.index else None
            if self.flip is not None:
                self.flip.times[0] -= 1
