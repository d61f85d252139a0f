"""Integer nanoseconds and everything that happens in them.

A timeline holds callbacks at given times and *sources* (buses) that know when they want to act
next. Nothing here reads a clock: virtual time jumps from one happening to the next, and
pacing.py drives the very same calls against the wall clock. Equal times run in a fixed order:
callbacks as they were scheduled, then sources as they were added, so a run repeats byte by byte.
"""

from __future__ import annotations

from collections.abc import Callable
from heapq import heapify, heappop, heappush

NEVER = (1 << 63) - 1
_NEVER = NEVER
_FEW = 64  # timers among which nobody looks for cancelled ones


class Source:
    """The interface through which a timeline runs a bus.

    `next_ns` is when the source acts next (NEVER: only once something else happens). `run` acts
    on everything up to and including `limit_ns`, moving the timeline's `now_ns` along, and returns
    early, between two happenings, once the timeline is `interrupted`. A timeline that runs asks again once it was
    interrupted, or the source itself has run: `known_ns` is what it heard last.
    """

    def __init__(self) -> None:
        self.known_ns = 0

    def next_ns(self) -> int:
        raise NotImplementedError

    def wake_ns(self) -> int:
        """The time before which no program can see whether the source has acted: `next_ns`, or later."""
        return self.next_ns()

    def run(self, limit_ns: int) -> None:
        raise NotImplementedError


class Timer:
    """One scheduled callback; `cancel` may be called repeatedly."""

    __slots__ = ("background", "callback", "slack_ns", "time_ns")

    def __init__(
        self, time_ns: int, callback: Callable[[], None], background: bool, slack_ns: int = 0
    ) -> None:
        self.time_ns = time_ns
        self.slack_ns = slack_ns
        self.callback: Callable[[], None] | None = callback
        self.background = background

    def cancel(self) -> None:
        self.callback = None

    def __repr__(self) -> str:
        return f"<timer at {self.time_ns} ns{', cancelled or over' if self.callback is None else ''}>"


class Timeline:
    """One order of events for any number of buses."""

    def __init__(self) -> None:
        self.now_ns = 0
        self.interrupted = False
        self._halted = False
        self._sequence = 0
        self._timers: list[tuple[int, int, Timer]] = []
        self._most_timers = _FEW  # with more of them, cancelled ones go
        self._sources: list[Source] = []
        self._outdated = True  # what is known of sources

    def add(self, source: Source) -> None:
        self._outdated = True
        self._sources.append(source)

    def remove(self, source: Source) -> None:
        self._outdated = True
        self._sources = [other for other in self._sources if other is not source]

    def at(
        self, time_ns: int, callback: Callable[[], None], *, background: bool = False, slack_ns: int = 0
    ) -> Timer:
        """Call back at `time_ns`, or now if that has passed.

        A `background` timer (a periodic task's next turn) does not keep the timeline from being idle. A timer
        whose effect no program can see for `slack_ns` does not wake the thread that paces the timeline before.
        """
        timer = Timer(max(time_ns, self.now_ns), callback, background, slack_ns)
        self._sequence += 1
        if len(self._timers) >= self._most_timers:
            self._sweep()
        heappush(self._timers, (timer.time_ns, self._sequence, timer))
        self.interrupted = True
        return timer

    def halt(self) -> None:
        """Make the running `run_until` return right after the present happening."""
        self._halted = True
        self.interrupted = True

    def next_ns(self) -> int:
        """When anything happens next; NEVER when nothing will."""
        return min(self._next_timer_ns(), self.busy_ns())

    def wake_ns(self) -> int:
        """When the timeline must run next, so that programs notice everything in time; NEVER if nothing is due."""
        soonest = self._wake_timer_ns()
        for source in self._sources:
            soonest = min(soonest, source.wake_ns())
        return soonest

    def busy_ns(self) -> int:
        """When any source acts next, timers apart; NEVER when all of them rest."""
        self._outdated = True
        return self._busy_ns()

    def idle(self) -> bool:
        """True when no bus has anything to do and no timer but background ones waits."""
        self._outdated = True
        return self._idle()

    def run_until(self, limit_ns: int) -> bool:
        """Let everything up to and including `limit_ns` happen; False if `halt` cut it short."""
        self._begin()
        while self._step(limit_ns):
            if self._halted:
                return False
        if limit_ns > self.now_ns:
            self.now_ns = limit_ns
        return True

    def run_until_idle(self, limit_ns: int) -> bool:
        """Let things happen until nothing is left to do; False if that is not so by `limit_ns`."""
        self._begin()
        while not self._idle():
            if not self._step(limit_ns):
                return False
        return True

    def run_busy(self, limit_ns: int) -> bool:
        """Let everything up to `limit_ns` happen, but only for as long as a source acts by then.

        Ends at the time of the last happening; False if `halt` cut it short.
        """
        self._begin()
        while self._busy_ns() <= limit_ns and self._step(limit_ns):
            if self._halted:
                return False
        return True

    def _begin(self) -> None:
        self._halted = False
        self._outdated = True

    def _busy_ns(self) -> int:
        if self._outdated:
            self._ask_sources()
        soonest = _NEVER
        for source in self._sources:
            soonest = min(soonest, source.known_ns)
        return soonest

    def _idle(self) -> bool:
        if self._outdated:
            self._ask_sources()
        for source in self._sources:
            if source.known_ns != _NEVER:
                return False
        for _, _, timer in self._timers:
            if timer.callback is not None and not timer.background:
                return False
        return True

    def _ask_sources(self) -> None:
        for source in self._sources:
            source.known_ns = source.next_ns()
        self._outdated = False

    def _next_timer_ns(self) -> int:
        while self._timers and self._timers[0][2].callback is None:
            heappop(self._timers)
        return self._timers[0][0] if self._timers else _NEVER

    def _wake_timer_ns(self) -> int:
        soonest = self._next_timer_ns()
        if soonest == _NEVER or self._timers[0][2].slack_ns == 0:
            return soonest
        soonest = _NEVER
        for _, _, timer in self._timers:
            if timer.callback is not None:
                soonest = min(soonest, timer.time_ns + timer.slack_ns)
        return soonest

    def _sweep(self) -> None:
        """Remove cancelled timers early: a program that sets and cancels distant ones would fill the memory."""
        self._timers = [entry for entry in self._timers if entry[2].callback is not None]
        heapify(self._timers)
        self._most_timers = max(_FEW, 2 * len(self._timers))

    def _step(self, limit_ns: int) -> bool:
        """Run the next timer, or the next source for as long as nothing else is due."""
        if self._outdated:
            self._ask_sources()
        due_ns = self._next_timer_ns()
        first_ns = bound_ns = _NEVER
        first = None
        for source in self._sources:  # the first in time, and when it is the turn of another
            at_ns = source.known_ns
            if at_ns < first_ns:
                bound_ns = first_ns - 1  # at equal times those added earlier go first
                first_ns = at_ns
                first = source
            elif at_ns < bound_ns:
                bound_ns = at_ns
        if due_ns <= first_ns:
            return due_ns <= limit_ns and due_ns != _NEVER and self._run_timer()
        if first is None or first_ns > limit_ns:
            return False
        self.interrupted = False
        first.run(min(limit_ns, due_ns - 1, bound_ns))
        if self.interrupted:
            self._outdated = True
        elif not self._outdated:
            first.known_ns = first.next_ns()
        return True

    def _run_timer(self) -> bool:
        time_ns, _, timer = heappop(self._timers)
        callback, timer.callback = timer.callback, None
        self.now_ns = time_ns
        self._outdated = True
        if callback is not None:
            callback()
        return True
