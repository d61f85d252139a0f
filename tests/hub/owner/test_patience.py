"""Whom a hub in lockstep names for the time that stands (`canwire serve --patience`): never an innocent."""

from __future__ import annotations

import pytest

from canwire.boards.config.configuration import Config
from canwire.hub.owner.entrance import open_session
from canwire.hub.owner.lockstep.pace import LockstepPace
from canwire.hub.owner.lockstep.turns import Turns
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol.messages import AwaitTurn, JoinTime
from canwire.timeline import NEVER

pytestmark = [pytest.mark.core, pytest.mark.finding("machines 5")]
PATIENCE_S = 5.0


class Stage:
    """A hub whose clock is set by hand, with `expected` programs, and what it said of time that stands."""

    def __init__(self, expected: int = 1) -> None:
        world = World(Config.default(), turns=Turns(expected))
        assert world.lockstep is not None
        self._world, self._lockstep = world, world.lockstep
        self.said: list[str] = []
        world.warn = self.said.append
        self._clock_ns = 0
        self._pace = LockstepPace(world, PATIENCE_S, lambda: self._clock_ns)
        self._sessions: dict[str, Session] = {}
        self._pace.run()

    @property
    def standstill(self) -> str:
        return self._lockstep.standstill

    def joins(self, name: str) -> None:
        session = self._sessions[name] = open_session(self._world, name, 1, lambda _: None, None)
        self._lockstep.join(session, JoinTime(f"1-{name}", 1, name))
        self._pace.run()

    def waits(self, name: str, seconds: float | None = 0) -> None:
        until_ns = NEVER if seconds is None else self._world.timeline.now_ns + round(seconds * 1e9)
        self._lockstep.wait(self._sessions[name], AwaitTurn(1, until_ns))
        self._pace.run()

    def leaves(self, name: str) -> None:
        self._world.close_session(self._sessions[name])
        self._pace.run()
        self.said.clear()

    def passes(self, seconds: float) -> None:
        """On the clock: the hub looks whenever it wanted to look again, at the end as well."""
        end_ns = self._clock_ns + round(seconds * 1e9)
        while (wait_s := self._pace.run()) is not None and self._clock_ns + wait_s * 1e9 < end_ns:
            self._clock_ns += max(1, round(wait_s * 1e9))
        self._clock_ns = end_ns
        self._pace.run()


def test_who_comes_late_is_not_named() -> None:
    made = Stage()
    made.passes(10 * PATIENCE_S)
    made.joins("late")
    made.passes(0.9 * PATIENCE_S)
    assert not made.said
    made.passes(0.2 * PATIENCE_S)
    assert "late (1), thread 1, computes" in made.said.pop()


def test_neither_is_who_comes_long_after_all_others_have_left() -> None:
    made = Stage()
    made.joins("first")
    made.waits("first", 1.0)
    made.leaves("first")
    made.passes(10 * PATIENCE_S)
    made.joins("late")
    made.passes(0.9 * PATIENCE_S)
    assert not made.said


def test_who_is_missing_is_waited_for_from_the_first_one_on_and_answers_for_nothing() -> None:
    made = Stage(2)
    made.passes(10 * PATIENCE_S)
    made.joins("a")
    made.passes(0.9 * PATIENCE_S)
    assert not made.said
    made.passes(10 * PATIENCE_S)
    assert made.said == ["time stopped at 0.000000000 s: 1 of 2 programs did not join yet"]
    made.joins("b")
    made.passes(0.9 * PATIENCE_S)
    assert (len(made.said), made.standstill) == (1, "")


def test_who_runs_after_one_that_was_slow_is_not_named_nor_is_that_one_a_second_time() -> None:
    made = Stage(2)
    made.joins("a")
    made.joins("b")
    made.passes(10 * PATIENCE_S)
    assert "a (1), thread 1, computes" in made.said.pop()
    made.waits("a")
    made.passes(0.9 * PATIENCE_S)
    assert (made.said, made.standstill) == ([], "")
    made.waits("b")
    made.passes(0.9 * PATIENCE_S)
    assert not made.said


def test_many_that_take_a_while_at_one_instant_are_not_named() -> None:
    made = Stage(20)
    names = [f"ecu{number}" for number in range(20)]
    for name in names:
        made.joins(name)
    for name in names:
        made.passes(0.9 * PATIENCE_S)
        made.waits(name, 1.0)
    assert not made.said


@pytest.mark.parametrize("others_s", [0.0, 0.5 * PATIENCE_S])
def test_who_waits_for_nothing_again_and_again_is_named_once_and_not_the_others(others_s: float) -> None:
    made = Stage(2)
    made.joins("guilty")
    made.joins("innocent")
    made.passes(0.01)
    made.waits("guilty")
    made.passes(others_s)
    made.waits("innocent", 1.0)
    for _ in range(30):
        made.passes(0.1 * PATIENCE_S)
        made.waits("guilty")
    assert len(made.said) == 1
    assert "guilty (1), thread 1, and maybe others wait again and again" in made.standstill
    made.waits("guilty", 2.0)
    assert made.standstill == ""
    made.waits("innocent", 0)
    made.passes(1.1 * PATIENCE_S)
    assert "innocent (1), thread 1, computes" in made.said[1]


def test_who_computes_where_another_was_named_for_its_repeating_is_named_as_well() -> None:
    made = Stage(2)
    made.joins("a")
    made.joins("b")
    for _ in range(30):
        made.passes(0.1 * PATIENCE_S)
        made.waits("a")
        made.waits("b")
    assert "a (1), thread 1, and maybe others" in made.said.pop()
    made.waits("a")
    made.passes(1.1 * PATIENCE_S)
    assert "b (1), thread 1, computes" in made.said.pop()


def test_who_asks_without_end_and_never_waits_is_named() -> None:
    """As a loop on recv(0): the hub looks after each question."""
    made = Stage(2)
    made.joins("asks")
    made.joins("b")
    for _ in range(12):
        made.passes(0.1 * PATIENCE_S)
    assert len(made.said) == 1
    assert (
        "asks (1), thread 1, computes, asks again and again without waiting (as recv(0) does)" in made.said[0]
    )


def test_everybody_waits_without_a_timeout() -> None:
    made = Stage()
    made.joins("a")
    made.passes(0.9 * PATIENCE_S)
    made.waits("a", None)
    made.passes(0.9 * PATIENCE_S)
    assert not made.said
    made.passes(0.2 * PATIENCE_S)
    assert "everybody waits without a timeout" in made.said.pop()
