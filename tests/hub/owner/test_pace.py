"""How a hub's time passes, by a clock of the test's own: slices, what is late, and who is told."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from canwire.boards.config.configuration import Config
from canwire.hub.owner.pace import AHEAD_NS, LARGEST_GAP_NS, REST_NS, SLICE_NS, UNHEARD_NS, FastPace, RealPace
from canwire.hub.owner.world import World
from canwire.timeline import NEVER, Source

pytestmark = pytest.mark.core

MS = 1_000_000
GRAIN_NS = 10_000  # of bus time between two happenings
Make = Callable[..., Any]


class Heavy(Source):
    """A bus that acts every 10 us until it ends, and takes `cost_ns` of the clock each time."""

    def __init__(self, world: World, cost_ns: int, ends_ns: int = NEVER) -> None:
        self.clock_ns = 0
        self.acted = 0
        self._timeline = world.timeline
        self._cost_ns = cost_ns
        self.ends_ns = ends_ns
        self._next_ns = 0
        world.timeline.add(self)

    def next_ns(self) -> int:
        return self._next_ns if self._next_ns < self.ends_ns else NEVER

    def run(self, limit_ns: int) -> None:
        while self.next_ns() <= limit_ns:
            self._timeline.now_ns = self._next_ns
            self._next_ns += GRAIN_NS
            self.acted += 1
            self.clock_ns += self._cost_ns


class Paced:
    """A world with one heavy bus, its pace, and what was warned of."""

    def __init__(self, kind: type[RealPace], cost_ns: int, ends_ns: int = NEVER) -> None:
        self.world = World(Config.parse("[[bus]]\nname = 'can0'"))
        self.warned: list[str] = []
        self.world.warn = self.warned.append
        self.bus = Heavy(self.world, cost_ns, ends_ns)
        self.pace = kind(self.world, lambda: self.bus.clock_ns)

    def turn(self) -> int:
        """One look at the time, as the engine's; how much of the clock it took."""
        before_ns = self.bus.clock_ns
        wait_s = self.pace.run()
        took_ns = self.bus.clock_ns - before_ns
        self.bus.clock_ns += round((wait_s or 0) * 1e9)
        return took_ns


@pytest.mark.finding("faults 4")
@pytest.mark.parametrize("kind", [RealPace, FastPace])
@pytest.mark.parametrize("load", [0.3, 0.9, 1.1, 3, 30])
def test_a_turn_takes_a_few_milliseconds_whatever_there_is_to_do(kind: type[RealPace], load: float) -> None:
    paced = Paced(kind, round(GRAIN_NS * load))
    paced.bus.clock_ns += 900 * MS  # a backlog from before
    took = [paced.turn() for _ in range(300)]
    assert max(took) <= 2 * SLICE_NS
    assert paced.bus.acted > 0


@pytest.mark.finding("faults 4")
def test_a_bus_that_can_catch_up_does_and_nothing_is_left_out() -> None:
    paced = Paced(RealPace, GRAIN_NS // 2)
    paced.bus.clock_ns += LARGEST_GAP_NS - MS
    assert paced.pace.lateness()[0] == LARGEST_GAP_NS - MS
    while paced.pace.lateness()[0] > MS:
        paced.turn()
    assert paced.pace.lateness()[1] == paced.pace.skipped_ns == 0
    assert paced.world.timeline.now_ns == pytest.approx(paced.bus.clock_ns, abs=5 * MS)


@pytest.mark.finding("faults 4")
def test_one_that_cannot_says_by_how_much_and_the_account_is_exact() -> None:
    paced = Paced(RealPace, 3 * GRAIN_NS)
    while paced.bus.clock_ns < 20_000 * MS:
        paced.turn()
    behind_ns, skipped_ns = paced.pace.lateness()
    assert paced.world.timeline.now_ns + behind_ns + skipped_ns == pytest.approx(
        paced.bus.clock_ns, abs=2 * GRAIN_NS
    )
    assert behind_ns <= LARGEST_GAP_NS + 2 * SLICE_NS
    assert skipped_ns > 10_000 * MS
    assert 10 <= len(paced.warned) <= 20  # once a second at most
    assert "s behind the clock" in paced.warned[0]
    assert paced.world.lateness() == (behind_ns, skipped_ns)


def test_one_that_keeps_up_says_nothing() -> None:
    paced = Paced(RealPace, GRAIN_NS // 10)
    while paced.bus.clock_ns < 3_000 * MS:
        paced.turn()
    assert paced.warned == []
    assert paced.pace.lateness()[0] <= MS


@pytest.mark.finding("faults 4")
def test_fast_time_runs_ahead_in_slices() -> None:
    paced = Paced(FastPace, GRAIN_NS // 100)
    before_ns = paced.world.timeline.now_ns
    paced.turn()
    assert 0 < paced.world.timeline.now_ns - before_ns <= AHEAD_NS + GRAIN_NS
    for _ in range(100):
        assert paced.turn() <= SLICE_NS + MS
    assert paced.world.timeline.now_ns > 10 * paced.bus.clock_ns


def test_fast_time_ends_with_the_bus() -> None:
    """A timer beside it, later than what the bus does, is the clock's again."""
    paced = Paced(FastPace, GRAIN_NS // 100, ends_ns=5 * MS)
    rung: list[int] = []
    paced.world.timeline.at(20 * MS, lambda: rung.append(paced.bus.clock_ns))
    for _ in range(50):
        paced.turn()
    assert paced.bus.acted == 500
    assert len(rung) == 1


def test_fast_time_waits_for_no_timer_if_a_program_sends_while_it_looks_at_the_clock() -> None:
    paced = Paced(FastPace, 0, ends_ns=0)
    looks: list[int] = []

    def clock_ns() -> int:
        if looks:
            paced.bus.ends_ns = MS
        looks.append(0)
        return 0

    paced.world.timeline.at(20 * MS, lambda: None)
    assert paced.pace.run() == 0.02
    paced.pace = FastPace(paced.world, clock_ns)
    assert paced.pace.run() == 0.0
    paced.pace.run()
    assert paced.bus.acted == MS // GRAIN_NS


class Program:
    """A client, as the pace sees it."""

    def __init__(self) -> None:
        self.listens = False


def test_what_nobody_can_hear_of_is_looked_at_seldom_until_somebody_listens() -> None:
    paced, program = Paced(RealPace, 0), Program()
    paced.world.sessions.append(program)  # type: ignore[arg-type]
    looks = 0
    while paced.bus.clock_ns < 10 * UNHEARD_NS:
        paced.turn()
        looks += 1
    assert looks <= 12
    assert paced.bus.acted >= 9 * UNHEARD_NS // GRAIN_NS  # late, but all of it
    program.listens = True
    before_ns = paced.bus.clock_ns
    paced.turn()
    assert paced.bus.clock_ns - before_ns <= REST_NS
    before_ns, looks = paced.bus.clock_ns, 0
    while paced.bus.clock_ns < before_ns + UNHEARD_NS:
        paced.turn()
        looks += 1
    assert looks >= UNHEARD_NS // REST_NS


def test_a_hub_without_programs_and_one_with_a_board_outside_keep_to_the_clock() -> None:
    for outside in (False, True):
        paced = Paced(RealPace, 0)
        if outside:
            assert paced.world.reactor is not None
            paced.world.reactor.post(lambda: None)
            paced.world.sessions.append(Program())  # type: ignore[arg-type]
        longest_ns = 0
        while (before_ns := paced.bus.clock_ns) < UNHEARD_NS:
            paced.turn()
            longest_ns = max(longest_ns, paced.bus.clock_ns - before_ns)
        assert longest_ns <= REST_NS


@pytest.mark.parametrize("kind", [RealPace, FastPace])
def test_nobody_is_late_while_all_that_is_to_come_lies_ahead(kind: type[RealPace]) -> None:
    paced = Paced(kind, cost_ns=0, ends_ns=1)
    assert paced.world.timeline.wake_ns() >= 0
    paced.turn()
    assert paced.world.timeline.wake_ns() > paced.bus.clock_ns
    assert paced.pace.lateness() == (0, 0)
