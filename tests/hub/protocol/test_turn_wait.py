"""A program's end of the page that it shares with its hub; the doorbell plays the hub's end, in the same thread."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import closing

import pytest

from canwire.hub.owner.lockstep.shared_page import SharedPage
from canwire.hub.protocol.turn_wait import TurnWait


class Bench:
    """A page and the program's end of it. `ring` is done at each ring of the doorbell."""

    def __init__(self, page: SharedPage) -> None:
        self.page = page
        self.rings = 0
        self.ring: Callable[[], object] = lambda: None
        self.program = TurnWait(self.rung, *page.hand_over())

    def rung(self) -> None:
        self.rings += 1
        self.ring()

    def give(self) -> None:
        """The turn of a wait comes when the wait is over."""
        assert self.page.words.asked()
        self.page.give(self.page.words.until_ns())

    def told(self) -> tuple[bool, bool]:
        """Whether the program has asked its other threads, and this very one, to check again."""
        return self.page.words.stirred(), self.page.words.called()


@pytest.fixture
def bench() -> Iterator[Bench]:
    with closing(SharedPage(0)) as page:
        yield Bench(page)


def test_each_wait_rings_once_and_ends_at_its_turn(bench: Bench) -> None:
    bench.ring = bench.give
    assert [bench.program.wait(until_ns) for until_ns in (0, 700, 701)] == [0, 700, 701]
    assert bench.rings == 3
    assert bench.told() == (False, False)


def test_an_end_comes_to_the_wait_that_goes_on_and_to_all_later_ones(bench: Bench) -> None:
    bench.ring = bench.program.end
    assert [bench.program.wait(700) for _ in range(2)] == [None, None]
    bench.ring = bench.give
    assert bench.program.wait(800) == 800  # a turn that was given is a turn


def test_a_turn_of_an_earlier_wait_ends_no_later_one(bench: Bench) -> None:
    first = bench.program.begin(700)
    bench.give()
    second = bench.program.begin(900)
    assert [bench.program.given(asked) for asked in (first, second)] == [700, None]
    bench.program.rest()
    bench.give()
    bench.program.rest()
    assert bench.program.given(second) == 900
    assert bench.rings == 2


def test_only_a_thread_that_takes_no_turns_calls_the_one_that_does(bench: Bench) -> None:
    bench.program.stir()
    assert bench.told() == (True, True)  # nobody has waited yet
    bench.ring = bench.give
    bench.program.wait(700)
    bench.program.stir()
    assert bench.told() == (True, False)
    other = threading.Thread(target=bench.program.stir)
    other.start()
    other.join()
    assert bench.told() == (True, True)
    assert bench.rings == 1  # a message tells the hub of a stir
