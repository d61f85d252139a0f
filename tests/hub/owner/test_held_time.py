"""A lockstep hub's time that is held to the wall clock (`canwire serve --pace`); its clock is set by hand."""

from __future__ import annotations

import pytest

from canwire.boards.config.configuration import Config
from canwire.held_time import LATE_NS
from canwire.hub.owner.entrance import open_session
from canwire.hub.owner.lockstep.pace import LockstepPace
from canwire.hub.owner.lockstep.turns import Turns
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol.messages import AwaitTurn, JoinTime
from tests.cases import each

pytestmark = pytest.mark.core

LATE_S = LATE_NS / 1e9


class Stage:
    """A hub at this pace with one program, which has joined and runs."""

    def __init__(self, factor: float) -> None:
        self._world = World(Config.default(), turns=Turns(1))
        assert self._world.lockstep is not None
        self._lockstep = self._world.lockstep
        self._clock_ns = 0
        self._pace = LockstepPace(self._world, 1e6, lambda: self._clock_ns)
        self._sessions: dict[str, Session] = {}
        self.pace(factor)
        self.joins("first")

    @property
    def now_s(self) -> float:
        return self._world.timeline.now_ns / 1e9

    def pace(self, factor: float) -> None:
        self._lockstep.held.hold(factor)
        self._pace.run()

    def joins(self, name: str) -> None:
        session = self._sessions[name] = open_session(self._world, name, 1, lambda _: None, None)
        self._lockstep.join(session, JoinTime(f"1-{name}", 1, name))
        self._pace.run()

    def waits(self, seconds: float, name: str = "first") -> None:
        until_ns = self._world.timeline.now_ns + round(seconds * 1e9)
        self._lockstep.wait(self._sessions[name], AwaitTurn(1, until_ns))
        self._pace.run()

    def runs(self, name: str = "first") -> bool:
        running = self._lockstep.turns.running
        return running is not None and running.name == name

    def passes(self, seconds: float) -> None:
        """On the clock, in which the hub looks whenever it wanted to look again, and after that once more."""
        end_ns = self._clock_ns + round(seconds * 1e9)
        while (wait_s := self._pace.run()) is not None and self._clock_ns + wait_s * 1e9 < end_ns:
            self._clock_ns += max(1, round(wait_s * 1e9))
        self._clock_ns = end_ns
        self._pace.run()

    def asked_s(self) -> float:
        """The time that an onlooker's request finds."""
        self._pace.catch_up()
        return self.now_s


@each("factor", [0.1, 1, 10])
def test_a_second_takes_so_many_of_the_clock(factor: float) -> None:
    made = Stage(factor)
    made.waits(1.0)
    made.passes(0.5 / factor)
    assert not made.runs()
    assert made.now_s == pytest.approx(0.5, abs=0.01)
    made.passes(0.51 / factor)
    assert made.runs()
    assert made.now_s == 1.0


def test_without_a_pace_no_time_of_the_clock_is_waited_for() -> None:
    made = Stage(0)
    made.waits(3600.0)
    made.passes(0)
    assert made.runs()
    assert made.now_s == 3600.0


def test_it_is_switched_while_somebody_waits() -> None:
    made = Stage(1)
    made.waits(10.0)
    made.passes(1.0)
    made.pace(0.1)
    made.passes(10.0)
    assert made.now_s == pytest.approx(2.0, abs=0.02)
    made.pace(10)
    made.passes(0.1)
    assert made.now_s == pytest.approx(3.0, abs=0.02)
    made.pace(0)
    made.passes(0)
    assert made.runs()
    assert made.now_s == 10.0


def test_a_little_computing_is_made_up_for() -> None:
    made = Stage(1)
    for _ in range(100):
        made.passes(0.004)
        made.waits(0.010)
        made.passes(0.006)
    assert made.now_s == pytest.approx(1.0, abs=0.02)


def test_a_breakpoint_stops_time_for_all_and_is_not_made_up_for() -> None:
    made = Stage(1)
    made.joins("other")
    made.waits(1.0)
    made.passes(60.0)  # the other one has its turn, and stands at its breakpoint
    assert made.runs("other")
    assert made.now_s == 0
    made.waits(0.5, "other")
    made.passes(0.4)
    assert made.now_s == pytest.approx(0.4, abs=0.01)
    made.passes(0.7)
    assert made.now_s == 0.5
    assert made.runs("other")


def test_who_comes_late_finds_the_time_that_it_is() -> None:
    made = Stage(1)
    made.waits(1.0)
    made.passes(0.25)
    made.joins("late")
    made.passes(0)
    assert made.runs("late")
    assert made.now_s == pytest.approx(0.25, abs=0.01)


def test_who_looks_on_finds_the_clocks_time() -> None:
    made = Stage(1)
    made.waits(1.0)
    made.passes(0.0625)
    assert made.asked_s() == pytest.approx(0.0625, abs=0.001)


def test_time_that_nobody_was_there_for_is_left_out() -> None:
    made = Stage(1)
    made.passes(3600.0)
    made.waits(1.0)
    made.passes(LATE_S / 2)
    assert made.now_s <= LATE_S
