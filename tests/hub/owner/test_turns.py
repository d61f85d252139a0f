"""Whose turn it is: the logic alone, against a plain model of it."""

from __future__ import annotations

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    Bundle,
    RuleBasedStateMachine,
    consumes,
    initialize,
    invariant,
    precondition,
    rule,
)

from canwire.hub.owner.lockstep.turns import Participant, Turns
from canwire.timeline import NEVER

pytestmark = pytest.mark.core


def names(turns: Turns) -> list[str]:
    return [one.name for one in turns.everybody]


def turn(turns: Turns, now_ns: int) -> str | None:
    one = turns.next(now_ns)
    return None if one is None else one.name


def test_numbers_in_names_count_by_their_value() -> None:
    turns = Turns()
    for program, name in enumerate(["ecu10", "ecu2", "b", "ecu2b", "ECU"]):
        turns.add(name, program, 0)
    assert names(turns) == ["ECU", "b", "ecu2", "ecu2b", "ecu10"]


def test_a_list_of_names_goes_first_and_in_its_order() -> None:
    turns = Turns(2, ["z", "m"])
    assert turns.missing == "z, m"
    turns.add("a", 1, 0)
    turns.add("m", 2, 0)
    assert (turns.missing, turns.next(0), turns.until_ns()) == ("z", None, 0)
    turns.add("z", 3, 0)
    assert (turns.missing, names(turns)) == ("", ["z", "m", "a"])
    assert turn(turns, 0) == "z"


def test_nobody_runs_before_all_are_there_and_leaving_changes_nothing_later() -> None:
    turns = Turns(2)
    first = turns.add("a", 1, 0)
    assert (turns.missing, turns.next(0)) == ("1 of 2 programs", None)
    turns.add("b", 2, 0)
    turns.remove(first)
    assert (turns.missing, turn(turns, 0)) == ("", "b")


def test_among_equal_names_programs_and_then_threads_decide() -> None:
    turns = Turns()
    found = [turns.add("a", program, thread) for program, thread in ((2, 0), (1, 1), (1, 0))]
    assert list(turns.everybody) == [found[2], found[1], found[0]]


def test_one_that_waits_for_no_time_does_not_keep_others_from_their_turns() -> None:
    turns = Turns(3)
    everybody = {name: turns.add(name, number, 0) for number, name in enumerate("abc")}
    order = []
    for _ in range(6):
        one = turns.next(7)
        assert one is not None
        order.append(one.name)
        turns.wait(one, 7 if one is everybody["a"] else 20)
    assert order == ["a", "b", "c", "a", "a", "a"]
    assert turns.until_ns() == 7


def test_woken_while_it_runs_it_looks_again() -> None:
    turns = Turns()
    one = turns.add("a", 1, 0)
    assert turns.next(0) is one
    turns.wake(one)
    turns.wait(one, NEVER)
    assert turns.next(0) is one
    turns.wait(one, NEVER)
    assert turns.next(0) is None
    assert turns.until_ns() == NEVER


def test_nobody_means_that_time_stands() -> None:
    turns = Turns()
    one = turns.add("a", 1, 0)
    turns.next(0)
    turns.remove(one)
    turns.remove(one)
    assert (turns.until_ns(), turns.next(0), turns.running) == (0, None, None)


class TurnsMachine(RuleBasedStateMachine):
    """Participants come, wait, are woken and go; time passes as far as it may. Each turn is checked on the spot."""

    there = Bundle("there")

    def __init__(self) -> None:
        super().__init__()
        self.turns = Turns()
        self.now_ns = 0
        self.number = 0
        self.due: set[Participant] = set()  # woken
        self.until: dict[Participant, int] = {}  # of those that wait
        self.running: Participant | None = None
        self.since: dict[Participant, int] = {}  # turns of others at this instant since it became due
        self.log: list[tuple[int, str, int]] = []

    @initialize(expected=st.integers(1, 3))
    def begin(self, expected: int) -> None:
        self.turns = Turns(expected)
        self.expected = expected
        self.begun = False

    @rule(target=there, name=st.sampled_from(["a", "b", "b2", "b10"]), thread=st.integers(0, 3))
    def join(self, name: str, thread: int) -> Participant:
        self.number += 1
        one = self.turns.add(name, self.number, thread)
        self.due.add(one)
        self.until[one] = NEVER
        self.begun = self.begun or len(self.until) + (self.running is not None) >= self.expected
        return one

    @rule(one=consumes(there))
    def leave(self, one: Participant) -> None:
        self.turns.remove(one)
        self.due.discard(one)
        self.until.pop(one, None)
        if one is self.running:
            self.running = None

    @rule(one=there)
    def wake(self, one: Participant) -> None:
        self.turns.wake(one)
        self.due.add(one)

    @precondition(lambda self: self.running is not None)
    @rule(span_ns=st.one_of(st.integers(0, 5), st.just(NEVER)))
    def wait(self, span_ns: int) -> None:
        assert self.running is not None
        until_ns = min(NEVER, self.now_ns + span_ns)
        self.turns.wait(self.running, until_ns)
        self.until[self.running] = until_ns
        self.running = None

    @rule()
    def give(self) -> None:
        could = {one for one, until in self.until.items() if one in self.due or until <= self.now_ns}
        got = self.turns.next(self.now_ns)
        if self.running is not None or not self.begun or not could:
            assert got is None
            return
        assert got in could
        for other in could - {got}:  # nobody is passed over by one who had two turns meanwhile
            self.since[other] = self.since.get(other, 0) + 1
            assert self.since[other] <= 2 * len(self.until) + 2
        self.since.pop(got, None)
        self.due.discard(got)
        del self.until[got]
        self.running = got

    @rule(step_ns=st.integers(1, 10))
    def pass_time(self, step_ns: int) -> None:
        """As the pace does: only once nobody has a turn any more."""
        if self.running is not None:
            return
        self.give()
        if self.running is not None:
            return
        self.now_ns = max(self.now_ns, min(self.turns.until_ns(), self.now_ns + step_ns))
        assert all(until_ns >= self.now_ns for until_ns in self.until.values())
        self.since.clear()

    @invariant()
    def one_runs_at_a_time(self) -> None:
        assert self.turns.running is self.running
        assert [one for one in self.turns.everybody if not one.waits] == (
            [] if self.running is None else [self.running]
        )

    @invariant()
    def time_may_pass_until_the_first_wait_is_over(self) -> None:
        if self.running is not None or not self.begun:
            assert self.turns.until_ns() == 0
        elif self.until:
            assert self.turns.until_ns() == min(self.until.values())

    @invariant()
    def everybody_is_in_order(self) -> None:
        places = [one.place for one in self.turns.everybody]
        assert places == sorted(places)


TestTurns = TurnsMachine.TestCase
TestTurns.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
