"""How a hub's time passes while its engine runs: with the clock, or as fast as its readers can follow.

Nothing here waits: `run` runs what is due and returns how long the engine may wait for input.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

from canwire.boards.lateness import lateness_text
from canwire.hub.owner.unheard import unheard
from canwire.timeline import NEVER

if TYPE_CHECKING:
    from canwire.holding import Hold
    from canwire.hub.owner.world import World
    from canwire.pacing import Pacer

REST_NS = 400_000  # on average happenings closer together than this share a wake-up ...
BURST_NS = 4_000_000  # ... once they have been so for this long
UNHEARD_NS = 50_000_000  # interval of checks while no program can notice events of the timeline
AHEAD_NS = 50_000_000  # bus time that fast time runs at most before it looks for input again
SLICE_NS = 4_000_000  # time that is spent on the buses before the engine looks for input again ...
STEP_NS = 250_000  # ... which is asked for about this often ...
LONGEST_STEP_NS = 2_000_000  # ... and at least after so much bus time: what follows may be more work
WARN_NS = 1_000_000_000  # between two warnings of buses that cannot keep up
PATIENCE_NS = 200_000_000  # how long a full receive queue may hold up fast time
LARGEST_GAP_NS = 1_000_000_000  # a process that was stopped for longer does not make up for it
LONGEST_WAIT_NS = 3_600_000_000_000  # systems limit the length of a wait
_KEPT = 4096
# the same for the compiled form, which has them as C numbers
_REST, _BURST, _SLICE, _STEP, _LONGEST_STEP = REST_NS, BURST_NS, SLICE_NS, STEP_NS, LONGEST_STEP_NS
_LARGEST_GAP, _LONGEST_WAIT, _UNHEARD, _NEVER = LARGEST_GAP_NS, LONGEST_WAIT_NS, UNHEARD_NS, NEVER


class RealPace:
    """The timeline follows the monotonic clock.

    `lateness_ns` contains the delays of the latest events. `skipped_ns` is the time that the timeline leaves out,
    because this process could not run, or not fast enough. `clock_ns` is for tests.
    """

    def __init__(self, world: World, clock_ns: Callable[[], int] = time.monotonic_ns) -> None:
        self.held = False  # somebody else lets time pass, too: not while in `holding`
        self.lateness_ns: deque[int] = deque(maxlen=_KEPT)
        self.skipped_ns = 0
        self._world = world
        self._timeline = world.timeline
        self._bells = world.bells
        self._due = None if self._bells is None else self._bells.due
        self._monotonic_ns = clock_ns
        self._origin_ns = clock_ns() - self._timeline.now_ns
        self._rest_until_ns = 0
        self._step_ns = LONGEST_STEP_NS // 20  # bus time between two looks at the clock
        self._warned_ns = -WARN_NS
        world.lateness = self.lateness

    def lateness(self) -> tuple[int, int]:
        """How far bus time is behind the clock now, and the time left out since the start, in ns."""
        behind_ns = self._clock_ns() - self._timeline.wake_ns()
        return max(0, behind_ns), self.skipped_ns

    def holding(self) -> AbstractContextManager[object] | Hold:
        """A context for requests to the world, in which no other thread lets time pass."""
        return nullcontext()

    def catch_up(self) -> None:
        """Run what is due, for one slice of time at most, so that the next request finds the present bus time."""
        now_ns = self._clock_ns()
        late_ns = now_ns - self._timeline.wake_ns()
        if late_ns >= 0:
            if late_ns > _LARGEST_GAP:
                self._skip(late_ns)
                now_ns -= late_ns
                self._warn()
            self.lateness_ns.append(late_ns)
        if not self._in_steps(now_ns, False):
            self._rest_until_ns = 0
            self._warn()

    def _in_steps(self, limit_ns: int, busy: bool) -> bool:
        """Run the timeline up to this time, or until a slice of time is over: then False.

        A `busy` run lasts only as long as a bus has something to do.
        """
        began_ns = before_ns = self._monotonic_ns()
        due_ns = self._due_ns(busy)
        while due_ns <= limit_ns:
            self._run(min(limit_ns, due_ns + self._step_ns), busy)
            after_ns = self._monotonic_ns()
            spent_ns = after_ns - before_ns
            if spent_ns < _STEP:
                self._step_ns = min(2 * self._step_ns, _LONGEST_STEP)
            elif spent_ns > 2 * _STEP:
                self._step_ns = max(self._step_ns * _STEP // spent_ns, 1000)
            due_ns = self._due_ns(busy)
            if after_ns - began_ns >= _SLICE and due_ns <= limit_ns:
                return False
            before_ns = after_ns
        self._run(limit_ns, busy)
        return True

    def _due_ns(self, busy: bool) -> int:
        return self._timeline.busy_ns() if busy else self._timeline.next_ns()

    def _run(self, limit_ns: int, busy: bool) -> None:
        timeline = self._timeline
        if busy:
            timeline.run_busy(limit_ns)
        else:
            while not timeline.run_until(limit_ns):
                pass  # cut short between two events: continue with the next
        self.tell()

    def tell(self) -> None:
        """Give the signals that wait: each once for all events of a step."""
        if self._due and self._bells is not None:
            self._bells.ring()

    def _warn(self) -> None:
        """Once a second at most."""
        text = lateness_text(*self.lateness())
        now_ns = self._monotonic_ns()
        if text and self._world.warn is not None and now_ns - self._warned_ns >= WARN_NS:
            self._warned_ns = now_ns
            self._world.warn(text)

    def run(self) -> float | None:
        """Run what is due; returns the seconds until more is due, None: nothing is due before there is input."""
        due_ns = self._timeline.wake_ns()
        now_ns = self._clock_ns()
        if due_ns <= now_ns and self._rest_until_ns <= now_ns:
            self._rest_until_ns = max(self._rest_until_ns, now_ns - _BURST) + _REST
            self.catch_up()
            due_ns = self._timeline.wake_ns()
            now_ns = self._clock_ns()
            if due_ns < now_ns + _UNHEARD and unheard(self._world):
                self._rest_until_ns = now_ns + _UNHEARD
        elif self._rest_until_ns > now_ns + _REST and not unheard(self._world):
            self._rest_until_ns = now_ns  # somebody came to listen
        if due_ns >= _NEVER:
            return None
        wait_ns = max(due_ns, self._rest_until_ns) - now_ns
        return min(max(0, wait_ns), _LONGEST_WAIT) / 1e9

    def _clock_ns(self) -> int:
        return self._monotonic_ns() - self._origin_ns

    def _skip(self, span_ns: int) -> None:
        self._origin_ns += span_ns
        self._rest_until_ns = 0
        self.skipped_ns += span_ns


class FastPace(RealPace):
    """The timeline follows the clock while all buses are idle, and runs faster while one is active.

    A receive queue about to overflow stops time until its reader has read from it. If a reader does not read for too
    long, time follows the clock, and that reader loses frames; so other readers can still follow. Time also follows
    the clock while a bus only repeats frames that no node acknowledges.
    """

    def __init__(self, world: World, clock_ns: Callable[[], int] = time.monotonic_ns) -> None:
        super().__init__(world, clock_ns)
        self._patient_until_ns = 0

    def catch_up(self) -> None:
        if self._timeline.busy_ns() >= _NEVER or self._held_up():
            RealPace.catch_up(self)
        else:
            self._go_on_from_here()

    def run(self) -> float | None:
        timeline = self._timeline
        if timeline.busy_ns() >= _NEVER:
            return self._rest()
        if self._held_up():
            return RealPace.run(self)
        wait_ns = self._patience_ns()
        if wait_ns == 0:
            limit_ns = min(timeline.now_ns + AHEAD_NS, self._world.clear_until_ns)
            self._in_steps(max(limit_ns, timeline.busy_ns()), True)
        self._go_on_from_here()
        return self._rest() if timeline.busy_ns() >= _NEVER else wait_ns / 1e9

    def _rest(self) -> float | None:
        """Run what is due by the clock; if a program has made a bus busy meanwhile, there is nothing to wait for."""
        wait_s = RealPace.run(self)
        return wait_s if self._timeline.busy_ns() >= _NEVER else 0.0

    def _held_up(self) -> bool:
        """True if time has to follow the clock: a bus is not healthy, or a reader has not read for too long.

        A result holds until `clear_until_ns`, so that a small step of the bus needs no check of all queues.
        """
        world = self._world
        if self._timeline.now_ns < world.clear_until_ns:
            return False
        if not world.healthy():
            return True
        if not world.stalled():
            self._patient_until_ns = 0
            world.clear_until_ns = self._timeline.now_ns + min(AHEAD_NS, world.horizon_ns())
            return False
        if self._patient_until_ns == 0:
            self._patient_until_ns = self._monotonic_ns() + PATIENCE_NS
        return self._patience_ns() == 0

    def _patience_ns(self) -> int:
        """How much longer to wait for a reader, 0: not at all."""
        if self._patient_until_ns == 0:
            return 0
        return max(0, self._patient_until_ns - self._monotonic_ns())

    def _go_on_from_here(self) -> None:
        """Count the clock from the timeline's time from now on, so that time never goes back."""
        self._origin_ns = self._monotonic_ns() - self._timeline.now_ns
        self._rest_until_ns = 0


class BenchPace(RealPace):
    """The bench lets its time pass in its own thread; the engine runs in between."""

    def __init__(self, world: World, pacer: Pacer) -> None:
        super().__init__(world)
        self.held = True
        self._pacer = pacer

    def holding(self) -> AbstractContextManager[object] | Hold:
        return self._pacer.holding(leaving=self._pacer.wake)

    def lateness(self) -> tuple[int, int]:
        return self._pacer.behind_ns(), self._pacer.skipped_ns

    def catch_up(self) -> None:
        self._pacer.catch_up()

    def run(self) -> float | None:
        return None
