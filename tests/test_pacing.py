"""A timeline that the machine cannot keep up with: callers have their turn, and what is left out is counted."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from contextlib import closing

import pytest

from canwire import Frame, Lab
from canwire.pacing import LARGEST_GAP_NS, Pacer
from canwire.timeline import Timeline

pytestmark = [pytest.mark.realtime, pytest.mark.finding("faults-2 1")]

SECOND = 1_000_000_000


class Overrun:
    """A timeline of which everything is late from the first nanosecond on."""

    def __init__(self, timeline: Timeline) -> None:
        self.timeline = timeline
        self.happened = 0
        timeline.at(0, self._again)

    def _again(self) -> None:
        self.happened += 1
        self.timeline.at(self.timeline.now_ns + 1, self._again)


@pytest.fixture
def overrun() -> Overrun:
    return Overrun(Timeline())


@pytest.fixture
def pacer(overrun: Overrun) -> Iterator[Pacer]:
    with closing(Pacer(overrun.timeline)) as made:
        yield made


def test_callers_have_their_turn_however_late_it_is(pacer: Pacer) -> None:
    turns = []

    def take() -> None:
        for _ in range(5):
            with pacer.holding():
                turns.append(pacer.behind_ns())

    callers = [threading.Thread(target=take) for _ in range(3)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert len(turns) == 15
    assert max(turns) > 0


def test_who_waits_is_told_what_happens(overrun: Overrun, pacer: Pacer) -> None:
    for _ in range(5):
        already = overrun.happened
        assert pacer.wait(lambda already=already: overrun.happened > already, 60)  # type: ignore[misc]
    assert not pacer.wait(lambda: False, 0.001)


def test_what_is_left_out_is_counted_and_no_time_is_taken_back() -> None:
    clock = [7 * SECOND]
    timeline = Timeline()
    happened: list[int] = []
    pacer = Pacer(timeline, lambda: clock[0])
    told: list[int] = []
    pacer.when_late = lambda: told.append(pacer.skipped_ns)
    with closing(pacer):
        with pacer.holding():
            timeline.at(10, lambda: happened.append(pacer.behind_ns()))
            clock[0] += LARGEST_GAP_NS + 10
            before_ns = pacer.now_ns()
            pacer.wake()
        assert pacer.wait(lambda: bool(happened), 60)
        assert pacer.skipped_ns == 0, "a second late is made up for"
        with pacer.holding():
            timeline.at(timeline.now_ns, lambda: happened.append(pacer.behind_ns()))
            due_ns = timeline.now_ns
            clock[0] += 3 * SECOND
            before_ns = pacer.now_ns()
            pacer.wake()
        assert pacer.wait(lambda: len(happened) == 2, 60)
        assert pacer.skipped_ns == before_ns - due_ns
        assert told == [pacer.skipped_ns]
        assert pacer.now_ns() == before_ns
        clock[0] += 5 * SECOND
        assert pacer.now_ns() == due_ns + 5 * SECOND


def test_a_lab_says_what_it_left_out(caplog: pytest.LogCaptureFixture) -> None:
    with Lab(time="real") as lab:
        assert (lab.skipped_ns, lab.behind_ns) == (0, 0)
        assert lab.pacer is not None
        done = threading.Event()
        with caplog.at_level(logging.WARNING, "canwire"), lab.touch():
            lab.pacer._origin_ns -= 2 * SECOND  # as if this process had been stopped
            lab.timeline.at(0, done.set)
        assert done.wait(60)
        with lab.touch():
            assert lab.skipped_ns >= 2 * SECOND - SECOND // 2
        assert "has left out" in caplog.text


def test_a_lab_that_is_late_makes_buses_and_takes_frames() -> None:
    """The finding: the next call did not return in 25 s."""
    with Lab(time="real") as lab:
        a = lab.can_bus("one", bit_rate=1_000_000).node("a")
        with lab.touch():
            Overrun(lab.timeline)
        other = lab.can_bus("other").node("b")
        a.send(Frame(1))
        other.send(Frame(2))
        assert (a.pending, other.pending) == (1, 1)
