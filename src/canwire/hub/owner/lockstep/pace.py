"""How time passes for programs in lockstep: while all of them wait, as fast as possible or as the pace allows."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.errors import BadValue
from canwire.hub.owner.pace import SLICE_NS, RealPace
from canwire.timeline import NEVER

if TYPE_CHECKING:
    from canwire.hub.owner.lockstep.turns import Participant
    from canwire.hub.owner.world import World

PATIENCE_S = 5.0
_LONGEST_SILENCE_NS = (
    3_600_000_000_000  # of a wait of all programs without a timeout: boards' clocks tick without end
)
_STEP_NS = 2_000_000  # bus time between two looks at the clock
_SLICE, _NEVER = SLICE_NS, NEVER  # for the compiled form, which has them as C numbers


class LockstepPace(RealPace):
    """The timeline advances from one wait to the next.

    A warning names a thread that runs for `patience_s` of the clock, or for twice as long in turns at one instant.
    """

    def __init__(
        self, world: World, patience_s: float = PATIENCE_S, clock_ns: Callable[[], int] = time.monotonic_ns
    ) -> None:
        super().__init__(world, clock_ns)
        if world.lockstep is None:
            raise BadValue("a world whose programs keep one time is made with turns")
        self._lockstep = world.lockstep
        self._turns = world.lockstep.turns
        self._held = world.lockstep.held
        self._patience_ns = round(patience_s * 1e9)
        self._instant = -1  # bus time, when it was last looked at
        self._stand_given = 0  # what time waited for then: turns so far, ...
        self._stand_runs: Participant | None = None  # ... the running thread, ...
        self._missing: str | None = None  # ... missing programs (None: none has joined yet), ...
        self._stand_ns = clock_ns()  # ... and since when of the clock
        self._spent_ns: dict[Participant, int] = {}  # of the clock, in turns that ended at this instant
        self._told = self._told_of_repeats = False  # warned about this wait, about this instant

    def lateness(self) -> tuple[int, int]:
        return 0, 0

    def catch_up(self) -> None:
        """Without a pace, requests find the time of this instant; with one, time advances to that of the clock."""
        if not self._held.factor:
            return
        until_ns, now_ns = self._turns.until_ns(), self._timeline.now_ns
        if until_ns > now_ns:
            self._timeline.run_until(min(until_ns, self._limit_ns(min(until_ns, self._timeline.next_ns()))))

    def run(self) -> float | None:
        timeline = self._timeline
        began_ns = self._monotonic_ns()
        while True:
            self._lockstep.give_turn()
            until_ns = self._turns.until_ns()
            if until_ns <= timeline.now_ns:
                return self._watch(began_ns)
            due_ns = timeline.next_ns()
            if until_ns >= _NEVER:
                if due_ns > self._lockstep.turn_ns + _LONGEST_SILENCE_NS:
                    return self._watch(began_ns)
                until_ns = due_ns
            next_ns = min(until_ns, due_ns)
            limit_ns = self._limit_ns(next_ns)
            whole = timeline.run_until(min(until_ns, limit_ns, max(due_ns, timeline.now_ns) + _STEP_NS))
            if whole and limit_ns < next_ns:
                return float(self._held.wait_s(next_ns - limit_ns))
            if self._monotonic_ns() - began_ns >= _SLICE:
                return 0.0

    def _limit_ns(self, next_ns: int) -> int:
        if not self._held.factor:
            return _NEVER
        return self._held.limit_ns(self._timeline.now_ns, next_ns, self._monotonic_ns())

    def _watch(self, now_ns: int) -> float | None:
        """While no time passes: the seconds until a warning is due, None: no warning, or it was given."""
        self._look(now_ns)
        if self._told or not self._lockstep.occupied:
            return None
        long_ns = self._stand_ns + self._patience_ns
        repeats_ns = NEVER
        running = self._lockstep.turns.running
        if running is not None and not self._told_of_repeats:
            repeats_ns = self._stand_ns + 2 * self._patience_ns - self._spent_ns.get(running, 0)
        if now_ns < min(long_ns, repeats_ns):
            return min(long_ns, repeats_ns) / 1e9 - now_ns / 1e9
        repeats = now_ns < long_ns
        if repeats:
            self._told_of_repeats = True
        else:
            self._told = True
        self._lockstep.report_standstill(repeats)
        return self._watch(now_ns)

    def _look(self, now_ns: int) -> None:
        """Find out which thread time waits for, and since when.

        A thread is not blamed for time before it joined, nor for the turns of others at this instant. A turn that was
        reported for its length is not counted again.
        """
        lockstep, turns, instant = self._lockstep, self._turns, self._timeline.now_ns
        missing = turns.missing if lockstep.occupied else None
        if instant != self._instant:
            self._instant, self._told_of_repeats = instant, False
            self._spent_ns.clear()
        elif (turns.given, turns.running, missing) != (self._stand_given, self._stand_runs, self._missing):
            before, spent_ns = self._stand_runs, now_ns - self._stand_ns
            if before is not None and spent_ns < self._patience_ns:
                self._spent_ns[before] = self._spent_ns.get(before, 0) + spent_ns
        elif lockstep.occupied:
            return
        self._stand_given, self._stand_runs, self._missing = turns.given, turns.running, missing
        self._stand_ns, self._told = now_ns, False
        if not self._told_of_repeats:
            lockstep.standstill = ""
