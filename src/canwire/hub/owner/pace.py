"""How a hub's time passes while its engine runs: with the clock, or as quickly as its readers can follow.

Nothing here waits: `run` does what is due and tells how long the engine may wait for input.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING

from canwire.timeline import NEVER

if TYPE_CHECKING:
    from canwire.hub.owner.world import World
    from canwire.pacing import Pacer

REST_NS = 400_000  # on average happenings closer together than this share a wake-up ...
BURST_NS = 4_000_000  # ... once they have been so for this long
SLICE_NS = 50_000_000  # bus time that fast time runs before it looks for input again
PATIENCE_NS = 200_000_000  # how long a full receive queue may hold up fast time
LARGEST_GAP_NS = 1_000_000_000  # a process that was stopped for longer does not make up for it
LONGEST_WAIT_NS = 3_600_000_000_000  # systems do not count for ever
_KEPT = 4096


class RealPace:
    """The timeline follows the monotonic clock.

    `lateness_ns` holds how long after their time the latest happenings were run, `skipped_ns` time that passed
    while this process could not run at all, and that the timeline therefore leaves out.
    """

    def __init__(self, world: World) -> None:
        self.lateness_ns: deque[int] = deque(maxlen=_KEPT)
        self.skipped_ns = 0
        self._world = world
        self._timeline = world.timeline
        self._origin_ns = time.monotonic_ns() - self._timeline.now_ns
        self._rest_until_ns = 0

    def holding(self) -> AbstractContextManager[object]:
        """While something is asked of the world nobody else lets time pass."""
        return nullcontext()

    def catch_up(self) -> None:
        """Let everything happen that is due; what is asked of the world next gets the time that it is now."""
        now_ns = time.monotonic_ns() - self._origin_ns
        late_ns = now_ns - self._timeline.next_ns()
        if late_ns >= 0:
            if late_ns > LARGEST_GAP_NS:
                self._skip(late_ns)
                now_ns -= late_ns
            self.lateness_ns.append(late_ns)
        while not self._timeline.run_until(now_ns):
            pass  # cut short between two happenings: go on with the next

    def run(self) -> float | None:
        """Let what is due happen; the seconds until there is more to do, None: not before there is input."""
        due_ns = self._timeline.next_ns()
        now_ns = self._clock_ns()
        if due_ns <= now_ns and self._rest_until_ns <= now_ns:
            self._rest_until_ns = max(self._rest_until_ns, now_ns - BURST_NS) + REST_NS
            self.catch_up()
            due_ns = self._timeline.next_ns()
        if due_ns >= NEVER:
            return None
        wait_ns = max(due_ns, self._rest_until_ns) - self._clock_ns()
        return min(max(0, wait_ns), LONGEST_WAIT_NS) / 1e9

    def _clock_ns(self) -> int:
        return time.monotonic_ns() - self._origin_ns

    def _skip(self, span_ns: int) -> None:
        self._origin_ns += span_ns
        self._rest_until_ns = 0
        self.skipped_ns += span_ns


class FastPace(RealPace):
    """The timeline follows the clock while all buses rest, and leaves it behind while one has something to do.

    A receive queue about to overflow holds time up until its reader has taken something. A reader that takes
    nothing for too long loses frames at the clock's pace: so others can still follow. A bus that only repeats
    what nobody acknowledges keeps to the clock as well.
    """

    def __init__(self, world: World) -> None:
        super().__init__(world)
        self._patient_until_ns = 0

    def catch_up(self) -> None:
        if self._timeline.busy_ns() >= NEVER or self._held_up():
            super().catch_up()
        else:
            self._go_on_from_here()

    def run(self) -> float | None:
        timeline = self._timeline
        if timeline.busy_ns() >= NEVER or self._held_up():
            return super().run()
        wait_ns = self._patience_ns()
        if wait_ns == 0:
            limit_ns = min(timeline.now_ns + SLICE_NS, self._world.clear_until_ns)
            timeline.run_busy(max(limit_ns, timeline.busy_ns()))
        self._go_on_from_here()
        return super().run() if timeline.busy_ns() >= NEVER else wait_ns / 1e9

    def _held_up(self) -> bool:
        """Time has to keep to the clock: somebody needs it, or has been waited for in vain.

        What was found once holds until `clear_until_ns`: a small step of the bus costs no look at every queue.
        """
        world = self._world
        if self._timeline.now_ns < world.clear_until_ns:
            return False
        if not world.healthy():
            return True
        if not world.stalled():
            self._patient_until_ns = 0
            world.clear_until_ns = self._timeline.now_ns + min(SLICE_NS, world.horizon_ns())
            return False
        if self._patient_until_ns == 0:
            self._patient_until_ns = time.monotonic_ns() + PATIENCE_NS
        return self._patience_ns() == 0

    def _patience_ns(self) -> int:
        """How much longer a reader is waited for, 0: not at all."""
        if self._patient_until_ns == 0:
            return 0
        return max(0, self._patient_until_ns - time.monotonic_ns())

    def _go_on_from_here(self) -> None:
        """From now on the clock counts from the timeline's time, which so never goes back."""
        self._origin_ns = time.monotonic_ns() - self._timeline.now_ns
        self._rest_until_ns = 0


class BenchPace(RealPace):
    """The bench lets its time pass itself, in a thread of its own; the engine takes its turns in between."""

    def __init__(self, world: World, pacer: Pacer) -> None:
        super().__init__(world)
        self._pacer = pacer

    def holding(self) -> AbstractContextManager[object]:
        return self._locked()

    def catch_up(self) -> None:
        self._pacer.catch_up()

    def run(self) -> float | None:
        return None

    @contextmanager
    def _locked(self) -> Iterator[None]:
        with self._pacer.lock:
            yield
            self._pacer.wake()
