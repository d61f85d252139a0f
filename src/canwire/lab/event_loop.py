"""asyncio in virtual time: a loop whose clock is the lab's. When every task waits, the lab's time passes.

`asyncio.sleep(3600)` takes no real time, and ends after exactly one hour of the lab's time.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from selectors import DefaultSelector, SelectorKey
from typing import TYPE_CHECKING, Any, TypeVar

from canwire.timeline import NEVER

if TYPE_CHECKING:
    from canwire.held_time import HeldTime
    from canwire.timeline import Timeline

ResultT = TypeVar("ResultT")


class VirtualLoop(asyncio.SelectorEventLoop):
    """`time()` returns the time of the timeline in seconds."""

    def __init__(self, timeline: Timeline, held: HeldTime, kick: Callable[[], object]) -> None:
        self.timeline = timeline
        super().__init__(_PassingTime(timeline, held, kick))
        self._clock_resolution = 1e-9  # a timer is due at its nanosecond

    def time(self) -> float:
        return self.timeline.now_ns / 1e9

    async def shutdown_default_executor(self, timeout: float | None = None) -> None:
        """Wait without a timeout: threads need real time, but the 300 s of Python 3.12 and newer would be virtual."""
        await super().shutdown_default_executor()


class _PassingTime(DefaultSelector):
    """A selector that lets virtual time pass instead of sleeping: up to the next event or the timeout of the sleep."""

    def __init__(self, timeline: Timeline, held: HeldTime, kick: Callable[[], object]) -> None:
        super().__init__()
        self._timeline = timeline
        self._held = held
        self._kick = kick

    def select(self, timeout: float | None = None) -> list[tuple[SelectorKey, int]]:
        found = super().select(0)
        if found or timeout == 0:
            return found
        self._kick()
        next_ns = self._timeline.next_ns()
        if timeout is not None:
            next_ns = min(next_ns, self._timeline.now_ns + max(1, round(timeout * 1e9)))
        if next_ns >= NEVER:  # nothing will ever happen on the bench: only a thread can bring something
            return super().select(None)
        self._held.run(self._timeline, next_ns)
        self._held.rest()
        return super().select(0)


def run(
    timeline: Timeline,
    held: HeldTime,
    main: Coroutine[Any, Any, ResultT],
    kick: Callable[[], object] = lambda: None,
) -> ResultT:
    """Run `main` like asyncio.run, in the time of the timeline; `kick` is called before time passes."""
    with asyncio.Runner(loop_factory=lambda: VirtualLoop(timeline, held, kick)) as runner:
        return runner.run(main)
