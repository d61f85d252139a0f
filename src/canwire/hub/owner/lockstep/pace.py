"""How time passes for programs that keep it together: while all of them wait, and then as quickly as it can."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.errors import BadValue
from canwire.hub.owner.pace import SLICE_NS, RealPace
from canwire.timeline import NEVER

if TYPE_CHECKING:
    from canwire.hub.owner.world import World

PATIENCE_S = 5.0
_LONGEST_SILENCE_NS = (
    3_600_000_000_000  # that everybody waits for without a timeout: boards' clocks tick for ever
)
_STEP_NS = 2_000_000  # bus time between two looks at the clock


class LockstepPace(RealPace):
    """The timeline goes from one wait to the next; whoever runs for `patience_s` of the clock is named."""

    def __init__(
        self, world: World, patience_s: float = PATIENCE_S, clock_ns: Callable[[], int] = time.monotonic_ns
    ) -> None:
        super().__init__(world, clock_ns)
        if world.lockstep is None:
            raise BadValue("a world whose programs keep one time is made with turns")
        self._lockstep = world.lockstep
        self._patience_ns = round(patience_s * 1e9)
        self._turn = self._instant = -1  # turns given, bus time, when they were last looked at ...
        self._turn_ns = self._instant_ns = clock_ns()  # ... and since when they are so
        self._told = False

    def lateness(self) -> tuple[int, int]:
        return 0, 0

    def catch_up(self) -> None:
        """What is asked meanwhile finds the time of this instant."""

    def run(self) -> float | None:
        lockstep, timeline = self._lockstep, self._timeline
        began_ns = self._monotonic_ns()
        while True:
            lockstep.give_turn()
            until_ns = lockstep.turns.until_ns()
            if until_ns <= timeline.now_ns:
                return self._watch(began_ns)
            due_ns = timeline.next_ns()
            if until_ns >= NEVER:
                if due_ns > lockstep.turn_ns + _LONGEST_SILENCE_NS:
                    return self._watch(began_ns)
                until_ns = due_ns
            timeline.run_until(min(until_ns, max(due_ns, timeline.now_ns) + _STEP_NS))
            if self._monotonic_ns() - began_ns >= SLICE_NS:
                return 0.0

    def _watch(self, now_ns: int) -> float | None:
        """Time stands: the seconds until somebody has to be named for it, None: nobody, or that was done."""
        turn, instant = self._lockstep.turns.given, self._timeline.now_ns
        if instant != self._instant:
            self._instant, self._instant_ns, self._told = instant, now_ns, False
            self._lockstep.standstill = ""
        if turn != self._turn:
            self._turn, self._turn_ns = turn, now_ns
            if not self._lockstep.repeats:
                self._told, self._lockstep.standstill = False, ""
        if self._told or not self._lockstep.occupied:
            return None
        patience_ns = self._patience_ns
        if now_ns - self._turn_ns >= patience_ns or now_ns - self._instant_ns >= 2 * patience_ns:
            self._told = True
            self._lockstep.stands(now_ns - self._turn_ns < patience_ns)
            return None
        return min(self._turn_ns + patience_ns, self._instant_ns + 2 * patience_ns) / 1e9 - now_ns / 1e9
