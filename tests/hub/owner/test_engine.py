"""The engine: time against the clock, ahead of it and by hand; calls, posts, descriptors, failures, the end.

Clocks are compared by order and bounds that hold on any machine, however late it is.
"""

from __future__ import annotations

import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import pytest

from canwire import BadValue, HubLost
from canwire.hub.owner.engine import Engine
from canwire.platform import EventDescriptor
from canwire.timeline import NEVER, Source, Timeline

pytestmark = pytest.mark.core

MS = 1_000_000
AGES = 60.0  # seconds; only a broken build waits that long


class Work(Source):
    """A bus with something to do every `step_ns`, so many times."""

    def __init__(self, timeline: Timeline, step_ns: int) -> None:
        self.timeline = timeline
        self.step_ns = step_ns
        self.left = 0
        self.done_ns: list[int] = []
        self.fails = False
        self._at_ns = 0

    def next_ns(self) -> int:
        return self._at_ns if self.left else NEVER

    def run(self, limit_ns: int) -> None:
        while self.left and self._at_ns <= limit_ns and not self.timeline.interrupted:
            if self.fails:
                raise ArithmeticError("a broken bus")
            self.timeline.now_ns = self._at_ns
            self.done_ns.append(self._at_ns)
            self.left -= 1
            self._at_ns += self.step_ns

    def give(self, count: int) -> None:
        self._at_ns = self.timeline.now_ns + self.step_ns
        self.left = count
        self.timeline.interrupted = True


class World:
    """Stands in for hub/owner/world.py's: time, and what fast time asks."""

    def __init__(self) -> None:
        self.timeline = Timeline()
        self.work = Work(self.timeline, MS)
        self.timeline.add(self.work)
        self.reactor = None
        self.clear_until_ns = 0
        self.is_healthy = True
        self.room: Callable[[], bool] = lambda: True

    def healthy(self) -> bool:
        return self.is_healthy

    def stalled(self) -> bool:
        return not self.room()

    def horizon_ns(self) -> int:
        return 5 * MS


Make = Callable[[str], Engine]


@pytest.fixture
def make() -> Iterator[Make]:
    engines = []

    def made(kind: str) -> Engine:
        world: Any = World()
        engines.append(Engine(world, kind))
        return engines[-1]

    yield made
    for engine in engines:
        engine.close()


def world_of(engine: Engine) -> World:
    world: Any = engine.world
    return world  # type: ignore[no-any-return]


def now_ns(engine: Engine) -> int:
    return engine.call(lambda: engine.world.timeline.now_ns)


def until(engine: Engine, condition: Callable[[], bool]) -> None:
    """Wait until something holds that only happens in the engine's thread."""
    deadline = time.monotonic() + AGES
    while not engine.call(condition):
        assert time.monotonic() < deadline
        time.sleep(0.001)


# calls and posts, in every kind of time

KINDS = ["real", "fast", "virtual"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_call_returns_and_raises_as_its_work_does(make: Make, kind: str) -> None:
    engine = make(kind)
    assert engine.call(lambda: 42) == 42
    with pytest.raises(ZeroDivisionError):
        engine.call(lambda: 1 // 0)
    assert engine.failures == 0


@pytest.mark.parametrize("kind", KINDS)
def test_a_call_within_a_call_runs_at_once(make: Make, kind: str) -> None:
    engine = make(kind)
    assert engine.call(lambda: engine.call(lambda: "inner")) == "inner"


@pytest.mark.parametrize("kind", KINDS)
def test_posts_run_in_order_after_what_posts_them(make: Make, kind: str) -> None:
    engine = make(kind)
    order: list[str] = []

    def second() -> None:
        order.append("second")
        engine.post(lambda: order.append("fourth"))

    def work() -> None:
        engine.post(lambda: order.append("first"))
        engine.post(second)
        order.append("work")

    engine.call(work)
    engine.post(lambda: order.append("third"))
    until(engine, lambda: len(order) == 5)
    assert order[:3] == ["work", "first", "second"]
    assert sorted(order[3:]) == ["fourth", "third"]


@pytest.mark.parametrize("kind", KINDS)
def test_calls_of_many_threads_have_the_world_to_themselves(make: Make, kind: str) -> None:
    engine = make(kind)
    inside = [0]

    def work() -> None:
        inside[0] += 1
        time.sleep(0.0002)
        assert inside[0] == 1
        inside[0] -= 1

    def many() -> None:
        for _ in range(20):
            engine.call(work)

    threads = [threading.Thread(target=many) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(AGES)
    assert inside == [0]


def test_time_must_be_one_of_three(make: Make) -> None:
    with pytest.raises(BadValue, match="virtual"):
        make("slow")


# real time


def test_real_time_keeps_pace_with_the_clock(make: Make) -> None:
    engine = make("real")
    before = time.monotonic_ns()
    first = now_ns(engine)
    between = time.monotonic_ns()
    time.sleep(0.05)
    later = time.monotonic_ns()
    second = now_ns(engine)
    after = time.monotonic_ns()
    assert later - between <= second - first <= after - before


@pytest.mark.parametrize("busy_s", [0.0, 0.04], ids=["on time", "all late"])
def test_timers_run_in_order_and_never_early(make: Make, busy_s: float) -> None:
    """On a busy machine the thread may get its turn only when all of them are due: one turn, and one lateness."""
    engine = make("real")
    seen: list[tuple[int, int, int]] = []

    def happen(due_ns: int) -> None:
        seen.append((due_ns, engine.world.timeline.now_ns, time.monotonic_ns()))

    def begin() -> int:
        timeline = engine.world.timeline
        base_ns = timeline.now_ns
        for due_ms in (30, 10, 10, 20):
            due_ns = base_ns + due_ms * MS
            timeline.at(due_ns, partial(happen, due_ns))
        time.sleep(busy_s)
        return base_ns

    started = time.monotonic_ns()
    base_ns = engine.call(begin)
    until(engine, lambda: len(seen) == 4)
    assert [(due - base_ns) // MS for due, _, _ in seen] == [10, 10, 20, 30]
    assert all(at == due for due, at, _ in seen)
    assert all(wall - started >= due - base_ns for due, _, wall in seen)
    assert min(engine.lateness_ns()) >= 0
    assert max(engine.lateness_ns()) >= round(busy_s * 1e9) - 10 * MS


def test_what_is_due_happens_before_input_is_handled(make: Make) -> None:
    """Even when the engine gets to both too late."""
    engine = make("real")
    order: list[str] = []

    def begin() -> None:
        engine.world.timeline.at(engine.world.timeline.now_ns + MS, lambda: order.append("timer"))
        engine.post(lambda: order.append("input"))
        time.sleep(0.01)

    engine.call(begin)
    until(engine, lambda: len(order) == 2)
    assert order == ["timer", "input"]


def test_an_idle_engine_takes_no_processor_time(make: Make) -> None:
    engine = make("real")
    engine.call(lambda: engine.world.timeline.at(engine.world.timeline.now_ns + 10**13, lambda: None))
    before = engine.call(time.thread_time)
    time.sleep(0.3)
    assert engine.call(time.thread_time) - before < 0.1


def test_happenings_close_together_share_wake_ups(make: Make) -> None:
    """20,000 a second would be 20,000 turns of the loop, a core at work all the time."""
    engine = make("real")
    work = world_of(engine).work
    work.step_ns = 50_000
    engine.call(lambda: work.give(4000))
    until(engine, lambda: work.left == 0)
    assert len(work.done_ns) == 4000
    assert len(engine.lateness_ns()) < 2000


def test_time_stands_still_for_a_process_that_was_stopped(make: Make) -> None:
    """It must not send in a burst what it could not send while it was stopped."""
    started = time.monotonic_ns()
    engine = make("real")
    work = world_of(engine).work

    def stopped() -> None:
        work.give(10)
        time.sleep(1.2)

    engine.call(stopped)
    until(engine, lambda: work.left == 0)
    assert work.done_ns == [work.done_ns[0] + step * MS for step in range(10)]
    assert now_ns(engine) < time.monotonic_ns() - started - 1_000 * MS


# fast time


def test_fast_time_runs_ahead_while_there_is_work_and_never_back(make: Make) -> None:
    engine = make("fast")
    work = world_of(engine).work
    begun_ns, started = now_ns(engine), time.monotonic_ns()
    engine.call(lambda: work.give(100_000))  # 100 seconds of bus time
    seen = [begun_ns]
    while work.left:
        seen.append(now_ns(engine))
    assert seen == sorted(seen)
    assert now_ns(engine) - begun_ns >= 100_000 * MS
    assert now_ns(engine) - begun_ns > time.monotonic_ns() - started


def test_idle_fast_time_keeps_pace_with_the_clock(make: Make) -> None:
    engine = make("fast")
    engine.call(lambda: world_of(engine).work.give(1000))
    until(engine, lambda: world_of(engine).work.left == 0)
    before = time.monotonic_ns()
    first = now_ns(engine)
    time.sleep(0.02)
    second = now_ns(engine)
    assert 20 * MS <= second - first <= time.monotonic_ns() - before


def test_timers_run_in_order_with_the_bus(make: Make) -> None:
    engine = make("fast")
    world = world_of(engine)
    seen: list[tuple[int, int]] = []

    def begin() -> None:
        base_ns = world.timeline.now_ns
        world.work.give(100)
        for after_ms in (50, 10, 90):
            world.timeline.at(
                base_ns + after_ms * MS + 1,
                lambda: seen.append((world.timeline.now_ns - base_ns, len(world.work.done_ns))),
            )

    engine.call(begin)
    until(engine, lambda: world.work.left == 0)
    assert seen == [(after_ms * MS + 1, after_ms) for after_ms in (10, 50, 90)]


def test_a_bus_that_only_repeats_keeps_to_the_clock(make: Make) -> None:
    engine = make("fast")
    world = world_of(engine)
    world.is_healthy = False
    before = time.monotonic_ns()
    begun_ns = now_ns(engine)
    engine.call(lambda: world.work.give(100_000))
    until(engine, lambda: len(world.work.done_ns) >= 30)
    done_ns = engine.call(lambda: world.work.done_ns[-1])
    assert done_ns - begun_ns <= time.monotonic_ns() - before


def test_a_nearly_full_queue_holds_time_up_until_its_reader_rings(make: Make) -> None:
    engine = make("fast")
    world = world_of(engine)
    doorbell = EventDescriptor()
    rooms = [10]
    world.room = lambda: len(world.work.done_ns) < rooms[0]

    def rung() -> None:
        doorbell.clear()
        rooms[0] += 10

    engine.call(lambda: engine.watch(doorbell, rung))
    engine.call(lambda: world.work.give(60))
    for taken in range(5):
        until(engine, lambda: len(world.work.done_ns) >= rooms[0])
        assert len(world.work.done_ns) < rooms[0] + 6  # one more slice than there was room: horizon_ns
        doorbell.signal()
        until(engine, lambda taken=taken: rooms[0] == 20 + 10 * taken)  # type: ignore[misc]
    until(engine, lambda: world.work.left == 0)
    engine.call(lambda: engine.unwatch(doorbell))
    doorbell.close()


def test_a_reader_that_never_takes_anything_does_not_stop_the_bus(make: Make) -> None:
    """Nor may others lose frames for it: from then on the bus keeps to the clock."""
    engine = make("fast")
    world = world_of(engine)
    world.room = lambda: False
    before = time.monotonic_ns()
    begun_ns = now_ns(engine)
    engine.call(lambda: world.work.give(20))
    until(engine, lambda: world.work.left == 0)
    assert engine.call(lambda: world.work.done_ns[-1]) - begun_ns <= time.monotonic_ns() - before
    assert time.monotonic_ns() - before >= 200 * MS


# virtual time


def test_virtual_time_only_passes_by_hand(make: Make) -> None:
    engine = make("virtual")
    time.sleep(0.01)
    assert now_ns(engine) == 0
    engine.call(lambda: engine.world.timeline.run_until(5 * MS))
    assert now_ns(engine) == 5 * MS
    assert engine.lateness_ns() == []
    assert not engine.inside()
    assert engine.call(threading.current_thread) is threading.current_thread()


# descriptors


def test_descriptors_call_back_until_they_are_unwatched(make: Make) -> None:
    engine = make("real")
    bell = EventDescriptor()
    rung: list[threading.Thread] = []

    def ring() -> None:
        bell.clear()
        rung.append(threading.current_thread())

    engine.call(lambda: engine.watch(bell, ring))
    for count in (1, 2):
        bell.signal()
        until(engine, lambda count=count: len(rung) == count)  # type: ignore[misc]
    assert threading.current_thread() not in rung
    engine.call(lambda: engine.unwatch(bell))
    engine.call(lambda: engine.unwatch(bell))
    bell.signal()
    assert now_ns(engine) <= now_ns(engine)
    assert len(rung) == 2
    bell.close()


def test_one_callback_may_unwatch_another_that_is_due_as_well(make: Make) -> None:
    engine = make("real")
    bells = [EventDescriptor(), EventDescriptor()]
    rung: list[int] = []

    def ring(which: int) -> None:
        rung.append(which)
        for bell in bells:
            engine.unwatch(bell)

    def begin() -> None:
        for which, bell in enumerate(bells):
            engine.watch(bell, partial(ring, which))
            bell.signal()

    engine.call(begin)
    until(engine, lambda: bool(rung))
    assert len(rung) == 1
    for bell in bells:
        bell.close()


def test_writable_descriptors_call_back_too(make: Make) -> None:
    engine = make("real")
    here, there = socket.socketpair()
    seen: list[str] = []

    def readable() -> None:
        seen.append(here.recv(10).decode())

    def writable() -> None:
        seen.append("writable")
        engine.watch(here, readable)

    engine.call(lambda: engine.watch(here, lambda: seen.append("too early"), writable))
    until(engine, lambda: seen == ["writable"])
    there.send(b"x")
    until(engine, lambda: len(seen) == 2)
    assert seen == ["writable", "x"]
    engine.call(lambda: engine.unwatch(here))
    here.close()
    there.close()


# failures


def test_failures_are_shown_once_and_counted_and_the_engine_lives(
    make: Make, capfd: pytest.CaptureFixture[str]
) -> None:
    engine = make("real")
    bell = EventDescriptor()

    def fail() -> None:
        bell.clear()
        raise LookupError("the callback of a descriptor")

    def fail_in_time() -> None:
        raise LookupError("a timer")

    engine.call(lambda: engine.watch(bell, fail))
    for count in (1, 2):
        bell.signal()
        until(engine, lambda count=count: engine.failures == count)  # type: ignore[misc]
    engine.post(fail)
    engine.call(lambda: engine.world.timeline.at(0, fail_in_time))
    until(engine, lambda: engine.failures == 4)
    shown = capfd.readouterr().err
    assert shown.count("the callback of a descriptor") == 2  # its line in the traceback, and its text
    assert shown.count("LookupError: a timer") == 1
    assert "Traceback" in shown
    engine.call(lambda: engine.unwatch(bell))
    bell.close()


def test_a_bus_that_fails_at_every_turn_does_not_take_the_processor(
    make: Make, capfd: pytest.CaptureFixture[str]
) -> None:
    engine = make("fast")
    work = world_of(engine).work
    work.fails = True
    engine.call(lambda: work.give(5))
    until(engine, lambda: engine.failures > 3)
    before = engine.call(time.thread_time)
    time.sleep(0.2)
    assert engine.call(time.thread_time) - before < 0.1
    work.fails = False
    until(engine, lambda: work.left == 0)
    assert capfd.readouterr().err.count("ArithmeticError: a broken bus") == 1


# the end


@pytest.mark.parametrize("kind", KINDS)
def test_after_the_end_calls_raise_and_posts_are_dropped(make: Make, kind: str) -> None:
    engine = make(kind)
    ended: list[str] = []
    engine.when_closed(lambda: ended.append("one"))
    forgotten = partial(ended.append, "forgotten")
    engine.when_closed(forgotten)
    engine.forget(forgotten)
    engine.close()
    engine.close()
    assert engine.closed
    assert ended == ["one"]
    engine.post(lambda: ended.append("posted"))
    with pytest.raises(HubLost):
        engine.call(lambda: ended.append("called"))
    assert ended == ["one"]


def test_what_was_asked_before_the_end_still_gets_its_answer(make: Make) -> None:
    engine = make("real")
    began, asked = threading.Event(), threading.Event()
    answers: list[int] = []

    def slow() -> None:
        began.set()
        asked.wait(AGES)

    engine.post(slow)
    began.wait(AGES)
    asking = [threading.Thread(target=lambda: answers.append(engine.call(lambda: 1))) for _ in range(3)]
    for thread in asking:
        thread.start()
    while len(engine._posted) < 3:
        time.sleep(0.001)
    assert engine._loop is not None
    ending = threading.Thread(target=engine.close)
    ending.start()
    while not engine._loop.stopping:
        time.sleep(0.001)
    asked.set()
    for thread in (*asking, ending):
        thread.join(AGES)
    assert answers == [1, 1, 1]


def test_an_engine_may_be_closed_from_within(make: Make) -> None:
    engine = make("real")
    ended = threading.Event()
    engine.when_closed(ended.set)
    engine.call(engine.close)
    assert ended.wait(AGES)


def test_a_fork_cannot_use_its_parents_engine() -> None:
    script = """
import os, sys
from canwire import CanwireError, connect
hub = connect(time="real")
child = os.fork()
if child == 0:
    try:
        hub.boards()
    except CanwireError as error:
        assert hub.lost and "fork" in str(error), error
        connect(time="fast").boards()  # a fresh one works
        os._exit(7)
    os._exit(1)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
hub.boards()
"""
    subprocess.run([sys.executable, "-W", "ignore", "-c", script], check=True, timeout=60)
