"""The time of a lab: one timeline, virtual or at the pace of the wall clock, and the tasks that wait for it."""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Callable, Coroutine
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any, TypeVar

from canwire.errors import BadValue, Closed, NotIdle, WrongState
from canwire.forks import hear_of_forks
from canwire.held_time import HeldTime
from canwire.holding import Hold
from canwire.lab.selection import Selection
from canwire.pacing import Pacer
from canwire.timeline import NEVER, Timeline, Timer
from canwire.values.checks import LONGEST_NS, nanoseconds, pace, shown, whole

if TYPE_CHECKING:
    import asyncio  # 35 ms that only asyncio's users pay

    from canwire.threads.company import Company
    from canwire.threads.keeper import Keeper

ResultT = TypeVar("ResultT")
_CHUNK_NS = 100_000_000
_UNSHARED: AbstractContextManager[None] = contextlib.nullcontext()


def _never() -> bool:
    return False


class LabTime:
    """The part of a lab that its buses and nodes use.

    `pacer` is None in virtual time. `waiters` maps tasks that wait to their deadlines.
    """

    selection: Selection | None = None  # leaves some of the script's frames and faults out

    def __init__(self, time: str) -> None:
        if time not in ("virtual", "real"):
            raise BadValue(f"time {time!r}: 'virtual' or 'real'")
        self.timeline = Timeline()
        self.held = HeldTime()
        self.pacer = Pacer(self.timeline) if time == "real" else None
        if self.pacer is not None:
            self.pacer.when_late = self.pacer.warn
            hear_of_forks(self)
        self._company: Company | None = None
        self.waiters: dict[asyncio.Future[None], int] = {}
        self._soon: deque[Callable[[], None]] = deque()
        self._called_back = False
        self._closed = False
        self._left = False

    @property
    def now_ns(self) -> int:
        """Nanoseconds since the lab began."""
        return self.timeline.now_ns if self.pacer is None else self.pacer.now_ns()

    @property
    def closed(self) -> bool:
        return self._closed

    def run_for(self, seconds: float) -> None:
        """Let this number of seconds pass."""
        self.run_until(self.now_ns + nanoseconds("seconds", seconds))

    def run_until(self, time_ns: int) -> None:
        """Let time pass until `time_ns`, and run everything that is due at `time_ns`."""
        self.check_open()
        whole("time_ns", time_ns, 0, LONGEST_NS)
        if self._company is not None and self._company.waited_until(_never, time_ns) is not None:
            return
        if self.pacer is None:
            self.kick()
            while not self.held.run_through(self.timeline, time_ns):
                pass  # a halt for another waiter
        else:
            self.pacer.wait_until(time_ns)

    def run_until_idle(self) -> None:
        """Let time pass until all buses are idle and no timers wait, except periodic ones.

        Raises NotIdle when a bus has been busy for one second without transmitting a frame successfully.
        """
        self.check_open()
        if self.pacer is not None:
            self.pacer.wait(lambda: self.timeline.idle() or self._stalled() is not None, None)
        else:
            self.kick()
            while not self.held.run_until_idle(self.timeline, self.timeline.now_ns + _CHUNK_NS):
                if self.timeline.next_ns() > self.timeline.now_ns + _CHUNK_NS:
                    self.held.run_through(self.timeline, self.timeline.next_ns())
                if self._stalled() is not None:
                    break
        stalled = self._stalled()
        if stalled is not None:
            raise NotIdle(stalled)

    def at(self, time_ns: int, callback: Callable[[], None], *, background: bool = False) -> Timer:
        """Call `callback` at this time; `run_until_idle` does not wait for a `background` timer."""
        self.check_open()
        due_ns = whole("time_ns", time_ns, 0, LONGEST_NS)
        with self.touch():
            return self.timeline.at(due_ns, callback, background=background)

    async def sleep(self, seconds: float) -> None:
        """Wait for this number of seconds of the lab's time, while other tasks run; also under plain `asyncio.run`."""
        self.check_open()
        deadline_ns = self.now_ns + nanoseconds("seconds", seconds)
        await self.turn(deadline_ns)
        while self.now_ns < deadline_ns:
            await self.turn(deadline_ns)

    def run(self, main: Coroutine[Any, Any, ResultT]) -> ResultT:
        """`asyncio.run(main)` in the lab's time: asyncio.sleep, timeouts and loop.time() use it too.

        In virtual time `asyncio.sleep(3600)` takes no real time; in real time this is asyncio.run.
        """
        import asyncio

        if not asyncio.iscoroutine(main):
            raise TypeError(f"main {shown(main)}: must be a coroutine; lab.run_for(seconds) lets time pass")
        self.check_open()
        if self.pacer is not None:
            return asyncio.run(main)
        from canwire.lab.event_loop import run

        return run(self.timeline, self.held, main, self.kick)

    def set_pace(self, factor: float | None) -> None:
        """Let virtual time pass at `factor` times the wall clock, 0.0001 to 10000; None: as quickly as possible.

        The pace does not change the result. Time does not pass while the program computes; long delays are skipped, not
        made up for. Any thread or callback may call this. Raises BadValue, and WrongState in real time.
        """
        if self.pacer is not None:
            raise WrongState("a pace is for a lab in virtual time: this one's passes with the clock")
        self.held.hold(pace(factor))

    @property
    def behind_ns(self) -> int:
        """Real time only: how late the buses are, at most one second; longer delays are skipped."""
        return 0 if self.pacer is None else self.pacer.behind_ns()

    @property
    def skipped_ns(self) -> int:
        """Real time only: the time skipped so far, because the machine was too slow or was suspended."""
        return 0 if self.pacer is None else self.pacer.skipped_ns

    def lateness_ns(self) -> list[int]:
        """Real time only: how late each event was handled, in order."""
        return [] if self.pacer is None else self.pacer.lateness_ns()

    def close(self) -> None:
        """End the lab; a second call does nothing."""
        if self._closed:
            return
        try:
            if self.pacer is not None:
                self.pacer.close()  # before anything is closed: a script whose timer is due still finds its node
        finally:
            self._closed = True
            self._leave()

    def _stalled(self) -> str | None:
        """A description of a bus that makes no progress, or None; overridden by subclasses with buses."""
        return None

    def _leave(self) -> None:
        """Close the buses; overridden by subclasses with buses."""

    # for buses and nodes

    def soon(self, callback: Callable[[], None]) -> None:
        """Call `callback` at the present time, after the current event. Callbacks at one time share a timer."""
        self._soon.append(callback)
        self._call_back_soon()

    def _call_back_soon(self) -> None:
        if not self._called_back:
            self._called_back = True
            self.timeline.at(self.timeline.now_ns, self._call_back)

    def _call_back(self) -> None:
        self._called_back = False
        try:
            while self._soon:
                self._soon.popleft()()
        finally:
            if self._soon:  # one of them raised: the others are not to blame
                self._call_back_soon()

    def touch(self) -> AbstractContextManager[None] | Hold:
        """Stop the timeline while it is changed, and wake its engine afterwards."""
        return _UNSHARED if self.pacer is None else self.pacer.working()

    def advance(self, deadline_ns: int, ready: Callable[[], bool]) -> bool:
        """Let time pass until `ready` returns a result, or until the deadline; nodes halt the timeline for arrivals."""
        if self.pacer is not None:
            return self.pacer.wait(ready, max(0.0, (deadline_ns - self.now_ns) / 1e9))
        if (
            self._company is not None
            and (found := self._company.waited_until(ready, deadline_ns)) is not None
        ):
            return found
        self.kick()
        while not ready():
            if self.held.run_through(self.timeline, deadline_ns):
                return ready()
        return True

    async def turn(self, deadline_ns: int, ready: Callable[[], bool] = _never) -> None:
        """Let other tasks run; if none of them does anything, let time pass until the next event."""
        import asyncio

        waiter = asyncio.get_running_loop().create_future()
        self.waiters[waiter] = deadline_ns
        try:
            if ready():  # the engine was quicker, and tells nobody a second time
                return
            for _ in range(3):
                await asyncio.sleep(0)
                if waiter.done():
                    return
            await self._pass_time(waiter, min(self.waiters.values()))
        finally:
            self.waiters.pop(waiter, None)

    def active(self) -> None:
        """Wake the waiting tasks: something has happened."""
        for waiter in list(self.waiters):
            try:
                waiter.get_loop().call_soon_threadsafe(_resolve, waiter)
            except RuntimeError:
                if not waiter.get_loop().is_closed():
                    raise
                self.waiters.pop(waiter, None)  # of a task that never continues

    def keeper(self) -> Keeper | None:
        """For canwire.in_time: the object that lets time pass, or None in real time."""
        from canwire.lab.keeper import LabKeeper

        return None if self.pacer is not None else LabKeeper(self.timeline, self.held, self.kick)

    def kick(self) -> None:
        """Called before time passes, for subclasses that send what programs have queued."""

    def check_open(self) -> None:
        """Raise Closed after `close`."""
        if self._closed:
            self.check_here()
            raise Closed("this lab")

    def check_here(self) -> None:
        """Raise CanwireError in a forked process, where a lab in real time has no engine."""
        if self._left:
            assert self.pacer is not None
            self.pacer.check()

    def leave_to_parent(self) -> None:
        """In a forked process: end a lab in real time. (A lab in virtual time is an independent copy there.)"""
        assert self.pacer is not None
        self.pacer.leave_to_parent()
        self._closed = self._left = True

    async def _pass_time(self, waiter: asyncio.Future[None], deadline_ns: int) -> None:
        import asyncio

        if self.pacer is not None:
            timeout = None if deadline_ns >= NEVER else max(0.0, (deadline_ns - self.now_ns) / 1e9)
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(waiter, timeout)
            self.pacer.check()
            return
        loop = waiter.get_loop()
        if getattr(loop, "timeline", None) is self.timeline:  # time passes there, when all tasks wait
            timer = None if deadline_ns >= NEVER else loop.call_at(deadline_ns / 1e9, _resolve, waiter)
            await waiter
            if timer is not None:
                timer.cancel()
            return
        self.kick()
        due_ns = self.timeline.next_ns()
        if due_ns > deadline_ns:
            self.held.run_through(self.timeline, deadline_ns)
        elif due_ns >= NEVER:
            await waiter  # nothing will ever happen unless another task makes it
        else:
            self.held.run_through(self.timeline, due_ns)


def _resolve(waiter: asyncio.Future[None]) -> None:
    if not waiter.done():
        waiter.set_result(None)
