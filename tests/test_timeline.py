"""One order of events: by time, then timers as they were set, then sources as they were added."""

from __future__ import annotations

import gc
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.timeline import NEVER, Source, Timeline, Timer
from tests.effort import examples

pytestmark = pytest.mark.core

LATE = 10**12


class Ticks(Source):
    """A bus of sorts: acts at given times, as `Source` demands, and writes into a log what it did when."""

    def __init__(self, timeline: Timeline, log: list[tuple[int, str]], name: str, times: list[int]) -> None:
        self.timeline = timeline
        self.log = log
        self.name = name
        self.times = sorted(times)
        self.limits: list[int] = []
        self.then: dict[int, Callable[[], object]] = {}
        timeline.add(self)

    def next_ns(self) -> int:
        return self.times[0] if self.times else NEVER

    def run(self, limit_ns: int) -> None:
        self.limits.append(limit_ns)
        while self.times and self.times[0] <= limit_ns:
            at_ns = self.times.pop(0)
            self.timeline.now_ns = at_ns
            self.log.append((at_ns, self.name))
            if at_ns in self.then:
                self.then.pop(at_ns)()
            if self.timeline.interrupted:
                return


class Bench:
    """A timeline with a log that timers and sources share."""

    def __init__(self) -> None:
        self.timeline = Timeline()
        self.log: list[tuple[int, str]] = []

    def timer(
        self, time_ns: int, name: str, then: Callable[[], object] | None = None, background: bool = False
    ) -> Timer:
        def ring() -> None:
            self.log.append((self.timeline.now_ns, name))
            if then is not None:
                then()

        return self.timeline.at(time_ns, ring, background=background)

    def source(self, name: str, *times: int) -> Ticks:
        return Ticks(self.timeline, self.log, name, list(times))


@pytest.fixture
def bench() -> Bench:
    return Bench()


class TestTimers:
    def test_run_in_order_of_time(self, bench: Bench) -> None:
        for time_ns in (30, 10, 20):
            bench.timer(time_ns, "t")
        assert bench.timeline.run_until(LATE)
        assert bench.log == [(10, "t"), (20, "t"), (30, "t")]

    def test_equal_times_run_as_they_were_set(self, bench: Bench) -> None:
        for name in "cab":
            bench.timer(10, name)
        bench.timeline.run_until(10)
        assert [name for _, name in bench.log] == list("cab")

    def test_one_set_for_now_runs_after_those_that_wait_for_now(self, bench: Bench) -> None:
        bench.timer(10, "a", then=lambda: bench.timer(10, "late"))
        bench.timer(10, "b")
        bench.timeline.run_until(10)
        assert bench.log == [(10, "a"), (10, "b"), (10, "late")]

    @pytest.mark.parametrize("passed_ns", [-5, 0, 49])
    def test_one_set_for_the_past_runs_now(self, bench: Bench, passed_ns: int) -> None:
        bench.timeline.run_until(50)
        assert bench.timer(passed_ns, "t").time_ns == 50
        bench.timeline.run_until(50)
        assert bench.log == [(50, "t")]

    def test_the_limit_itself_is_included(self, bench: Bench) -> None:
        bench.timer(10, "a")
        bench.timer(11, "b")
        bench.timeline.run_until(10)
        assert bench.log == [(10, "a")]

    def test_never_comes_never(self, bench: Bench) -> None:
        bench.timer(NEVER, "t")
        bench.timeline.run_until(NEVER)
        assert bench.log == []

    def test_an_exception_comes_out_and_the_rest_still_runs_later(self, bench: Bench) -> None:
        def fail() -> None:
            raise LookupError("on purpose")

        bench.timer(10, "a", then=fail)
        bench.timer(10, "b")
        with pytest.raises(LookupError, match="on purpose"):
            bench.timeline.run_until(20)
        assert bench.timeline.now_ns == 10
        bench.timeline.run_until(20)
        assert bench.log == [(10, "a"), (10, "b")]


class TestCancel:
    def test_a_cancelled_timer_does_not_run(self, bench: Bench) -> None:
        timer = bench.timer(10, "a")
        bench.timer(10, "b")
        timer.cancel()
        timer.cancel()
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "b")]

    def test_is_no_happening(self, bench: Bench) -> None:
        bench.timer(10, "a").cancel()
        assert bench.timeline.next_ns() == NEVER
        assert bench.timeline.idle()

    def test_by_one_of_the_same_time(self, bench: Bench) -> None:
        bench.timer(10, "a", then=lambda: victim.cancel())
        victim = bench.timer(10, "b")
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "a")]

    def test_after_it_ran_changes_nothing(self, bench: Bench) -> None:
        timer = bench.timer(10, "a")
        bench.timer(20, "b")
        bench.timeline.run_until(10)
        timer.cancel()
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "a"), (20, "b")]

    def test_of_itself_while_it_runs(self, bench: Bench) -> None:
        timer = bench.timer(10, "a", then=lambda: timer.cancel())
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "a")]


class TestSources:
    def test_take_turns_by_time(self, bench: Bench) -> None:
        bench.source("A", 10, 30, 50)
        bench.source("B", 20, 40)
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "A"), (20, "B"), (30, "A"), (40, "B"), (50, "A")]

    def test_equal_times_run_as_they_were_added(self, bench: Bench) -> None:
        for name in "CAB":
            bench.source(name, 10, 20)
        bench.timeline.run_until(LATE)
        assert [name for _, name in bench.log] == list("CABCAB")

    def test_equal_times_run_as_they_were_added_even_when_the_later_one_is_already_running(
        self, bench: Bench
    ) -> None:
        bench.source("A", 20)
        bench.source("B", 10, 20)
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "B"), (20, "A"), (20, "B")]

    def test_timers_run_before_sources_of_the_same_time(self, bench: Bench) -> None:
        bench.source("A", 10, 20)
        for time_ns in (20, 10):
            bench.timer(time_ns, "t")
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "t"), (10, "A"), (20, "t"), (20, "A")]

    def test_a_timer_set_by_a_source_interrupts_it(self, bench: Bench) -> None:
        source = bench.source("A", 10, 20, 30)
        source.then[10] = lambda: bench.timer(20, "t")
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "A"), (20, "t"), (20, "A"), (30, "A")]

    def test_a_timer_set_for_now_by_a_source_comes_before_the_other_sources(self, bench: Bench) -> None:
        first = bench.source("A", 10)
        bench.source("B", 10)
        first.then[10] = lambda: bench.timer(10, "t")
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "A"), (10, "t"), (10, "B")]

    def test_run_as_far_as_nothing_else_is_due(self, bench: Bench) -> None:
        source = bench.source("A", 10, 20, 30)
        bench.timer(25, "t")
        bench.timeline.run_until(100)
        assert source.limits == [24, 100]

    def test_one_removed_acts_no_more(self, bench: Bench) -> None:
        gone, kept = bench.source("A", 10), bench.source("B", 10)
        bench.timeline.remove(gone)
        bench.timeline.remove(gone)
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "B")]
        assert kept.times == []

    def test_one_that_gets_work_from_a_timer(self, bench: Bench) -> None:
        source = bench.source("A")
        bench.timer(10, "t", then=lambda: source.times.append(10))
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "t"), (10, "A")]

    def test_an_exception_comes_out(self, bench: Bench) -> None:
        def fail() -> None:
            raise LookupError("on purpose")

        bench.source("A", 10, 20).then[10] = fail
        with pytest.raises(LookupError, match="on purpose"):
            bench.timeline.run_until(LATE)
        bench.timeline.run_until(LATE)
        assert bench.log == [(10, "A"), (20, "A")]

    def test_a_source_without_methods_says_so(self, bench: Bench) -> None:
        bench.timeline.add(Source())
        with pytest.raises(NotImplementedError):
            bench.timeline.next_ns()


class TestRunUntil:
    def test_time_arrives_where_nothing_happens(self, bench: Bench) -> None:
        assert bench.timeline.run_until(123)
        assert bench.timeline.now_ns == 123

    def test_time_never_runs_backwards(self, bench: Bench) -> None:
        bench.timeline.run_until(100)
        assert bench.timeline.run_until(50)
        assert bench.timeline.now_ns == 100

    def test_halt_returns_after_the_present_happening(self, bench: Bench) -> None:
        bench.timer(10, "a", then=bench.timeline.halt)
        bench.timer(10, "b")
        assert not bench.timeline.run_until(100)
        assert (bench.log, bench.timeline.now_ns) == ([(10, "a")], 10)
        assert bench.timeline.run_until(100)
        assert (bench.log, bench.timeline.now_ns) == ([(10, "a"), (10, "b")], 100)

    def test_halt_inside_a_source(self, bench: Bench) -> None:
        bench.source("A", 10, 20).then[10] = bench.timeline.halt
        assert not bench.timeline.run_until(100)
        assert (bench.log, bench.timeline.now_ns) == ([(10, "A")], 10)
        assert bench.timeline.run_until(100)
        assert bench.log == [(10, "A"), (20, "A")]

    def test_halt_before_a_run_is_forgotten(self, bench: Bench) -> None:
        bench.timer(10, "a")
        bench.timeline.halt()
        assert bench.timeline.run_until(100)
        assert bench.log == [(10, "a")]


class TestIdle:
    def test_from_the_start(self, bench: Bench) -> None:
        assert bench.timeline.idle()
        assert bench.timeline.run_until_idle(100)
        assert bench.timeline.now_ns == 0

    def test_a_background_timer_keeps_nobody_waiting(self, bench: Bench) -> None:
        bench.timer(10, "t", background=True)
        assert bench.timeline.idle()
        assert bench.timeline.next_ns() == 10
        assert bench.timeline.run_until_idle(100)
        assert bench.log == []

    def test_a_background_timer_runs_on_the_way(self, bench: Bench) -> None:
        bench.timer(10, "behind", background=True)
        bench.timer(20, "t")
        bench.timer(30, "behind", background=True)
        assert bench.timeline.run_until_idle(100)
        assert bench.log == [(10, "behind"), (20, "t")]
        assert bench.timeline.now_ns == 20

    def test_a_periodic_timer_never_stops_it(self, bench: Bench) -> None:
        def again() -> None:
            bench.timer(bench.timeline.now_ns + 10, "turn", then=again, background=True)

        again()
        bench.source("A", 35)
        assert bench.timeline.run_until_idle(1000)
        assert bench.log == [(10, "turn"), (20, "turn"), (30, "turn"), (35, "A")]

    def test_time_stays_at_the_last_happening(self, bench: Bench) -> None:
        bench.source("A", 10, 20)
        bench.timer(15, "t")
        assert bench.timeline.run_until_idle(100)
        assert bench.timeline.now_ns == 20

    def test_false_at_the_limit(self, bench: Bench) -> None:
        bench.source("A", 10, 101)
        assert not bench.timeline.run_until_idle(100)
        assert bench.log == [(10, "A")]
        assert not bench.timeline.idle()
        assert bench.timeline.run_until_idle(101)

    def test_false_with_a_timer_beyond_the_limit(self, bench: Bench) -> None:
        bench.timer(101, "t")
        assert not bench.timeline.run_until_idle(100)
        assert bench.timeline.run_until_idle(101)
        assert bench.log == [(101, "t")]

    def test_next_ns_is_the_soonest_of_all(self, bench: Bench) -> None:
        assert bench.timeline.next_ns() == NEVER
        bench.source("A", 30)
        assert bench.timeline.next_ns() == 30
        timer = bench.timer(20, "t")
        assert bench.timeline.next_ns() == 20
        bench.source("B", 10)
        assert bench.timeline.next_ns() == 10
        timer.cancel()
        bench.timeline.run_until(10)
        assert bench.timeline.next_ns() == 30


# a plan: what each source does when; timers and the delay of one more that they set; such delays of sources
moments = st.integers(0, 12)
plans = st.tuples(
    st.lists(st.lists(moments, max_size=6), max_size=3),
    st.lists(st.tuples(moments, st.none() | st.integers(0, 4)), max_size=6),
    st.dictionaries(st.tuples(st.integers(0, 2), moments), st.integers(0, 4), max_size=4),
)
Plan = tuple[list[list[int]], list[tuple[int, int | None]], dict[tuple[int, int], int]]


def as_the_timeline_runs_it(plan: Plan, steps: list[int]) -> list[tuple[int, str]]:
    bench = Bench()
    sources, timers, reactions = plan

    def later(delay_ns: int | None) -> Callable[[], object] | None:
        if delay_ns is None:
            return None
        return lambda: bench.timer(bench.timeline.now_ns + delay_ns, "late")

    for number, times in enumerate(sources):
        source = bench.source(f"source {number}", *times)
        source.then = {at: later(delay) for (who, at), delay in reactions.items() if who == number}  # type: ignore[misc]
    for number, (time_ns, delay_ns) in enumerate(timers):
        bench.timer(time_ns, f"timer {number}", then=later(delay_ns))
    for limit_ns in [*sorted(steps), 1000]:
        assert bench.timeline.run_until(limit_ns)
    return bench.log


def as_the_rules_say(plan: Plan) -> list[tuple[int, str]]:
    """Of all that is to come, the smallest (time, timers first, order of setting or adding) happens next."""
    sources, timers, reactions = plan
    coming: list[tuple[int, int, int, str, int | None]] = []
    for source, times in enumerate(sources):
        coming += [(at, 1, source, f"source {source}", None) for at in times]
    coming += [(at, 0, number, f"timer {number}", delay) for number, (at, delay) in enumerate(timers)]
    used = dict(reactions)
    log, sequence = [], len(timers)
    while coming:
        happening = min(coming, key=lambda entry: entry[:3])
        coming.remove(happening)
        at, kind, number, name, delay = happening
        log.append((at, name))
        if kind == 1:
            delay = used.pop((number, at), None)
        if delay is not None:
            coming.append((at + delay, 0, sequence, "late", None))
            sequence += 1
    return log


@examples(100)
@given(plans)
def test_any_plan_runs_by_the_rules(plan: Plan) -> None:
    assert as_the_timeline_runs_it(plan, []) == as_the_rules_say(plan)


@pytest.mark.conforms("G-17")
@examples(100)
@given(plans, st.lists(moments, max_size=4) | st.just(list(range(20))))
def test_running_in_pieces_changes_nothing(plan: Plan, steps: list[int]) -> None:
    """As the paced timeline does it: the same happenings, however far each run goes."""
    assert as_the_timeline_runs_it(plan, steps) == as_the_timeline_runs_it(plan, [])


def there() -> int:
    """Timers in memory, called or not."""
    gc.collect()
    return sum(type(found) is Timer for found in gc.get_objects())


def test_who_sets_and_cancels_far_timers_fills_no_memory() -> None:
    """A fault that lasts for a day, a wait for an hour, taken back at once: any client may do that again and again."""
    timeline = Timeline()
    before = there()
    live = [timeline.at(LATE + number, lambda: None) for number in range(100)]
    for _ in range(10_000):
        timeline.at(LATE, lambda: None).cancel()
    assert there() - before <= 2 * len(live) + 1
    del live


def test_cancelled_ones_that_go_early_change_no_order(bench: Bench) -> None:
    kept = []
    for number in range(500):
        bench.timer(1000 - number // 3, f"{number}")
        bench.timeline.at(LATE, lambda: None).cancel()
        kept.append((1000 - number // 3, f"{number}"))
    bench.timeline.run_until(1000)
    assert bench.log == sorted(kept, key=lambda entry: entry[0])


def test_what_nobody_notices_wakes_nobody() -> None:
    timeline = Timeline()
    called: list[int] = []
    early = timeline.at(100, lambda: called.append(timeline.now_ns), slack_ns=50)
    assert (timeline.next_ns(), timeline.wake_ns()) == (100, 150)
    timeline.at(120, lambda: called.append(timeline.now_ns))
    assert (timeline.next_ns(), timeline.wake_ns()) == (100, 120)
    early.cancel()
    timeline.at(90, lambda: called.append(timeline.now_ns), slack_ns=5)
    assert (timeline.next_ns(), timeline.wake_ns()) == (90, 95)
    timeline.run_until(200)
    assert called == [90, 120]
    assert timeline.wake_ns() == NEVER
