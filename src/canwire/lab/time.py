"""Time on the bench: one timeline, as fast as it can or as the wall clock goes, and who waits for it."""

from __future__ import annotations

import contextlib
from collections import deque
from collections.abc import Callable, Coroutine, Iterator
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any, TypeVar

from canwire.errors import BadValue, Closed, NotIdle, WrongState
from canwire.forks import hear_of_forks
from canwire.held_time import HeldTime
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


class LabTime:
    """What a bench's buses and nodes know of their bench; it knows none of them.

    `pacer` is None in virtual time. `waiters` are the tasks that wait for something to happen, with their deadlines.
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
        """Let so many seconds pass."""
        self.run_until(self.now_ns + nanoseconds("seconds", seconds))

    def run_until(self, time_ns: int) -> None:
        """Let time pass until `time_ns`; everything due at that very moment happens too."""
        self.check_open()
        whole("time_ns", time_ns, 0, LONGEST_NS)
        if self._company is not None and self._company.waited_until(_never, time_ns) is not None:
            return
        if self.pacer is None:
            self.kick()
            while not self.held.run_through(self.timeline, time_ns):
                pass  # somebody's halt was not meant for us
        else:
            self.pacer.wait_until(time_ns)

    def run_until_idle(self) -> None:
        """Let time pass until no bus has anything to do and no timer waits (but for periodic ones).

        Raises NotIdle when a bus has been busy for a second without getting a single frame through.
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
        """Call back at this time; a background timer does not keep the lab from being idle."""
        self.check_open()
        due_ns = whole("time_ns", time_ns, 0, LONGEST_NS)
        with self.touch():
            return self.timeline.at(due_ns, callback, background=background)

    async def sleep(self, seconds: float) -> None:
        """Let so many seconds of the lab's time pass, while other tasks go on; also under plain `asyncio.run`."""
        self.check_open()
        deadline_ns = self.now_ns + nanoseconds("seconds", seconds)
        await self.turn(deadline_ns)
        while self.now_ns < deadline_ns:
            await self.turn(deadline_ns)

    def run(self, main: Coroutine[Any, Any, ResultT]) -> ResultT:
        """`asyncio.run(main)` with asyncio's own time being the lab's: asyncio.sleep, timeouts and loop.time() too.

        In virtual time `asyncio.sleep(3600)` takes no time; in real time this is asyncio.run.
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
        """Virtual time: from now on it passes `factor` times as quickly as the wall clock, 0.0001 to 10000.

        None: as quickly as it can. Nodes do the same at every pace. Time does not pass while the program computes; a
        longer delay is skipped. Any thread or callback may call this. Raises BadValue, WrongState in real time.
        """
        if self.pacer is not None:
            raise WrongState("a pace is for a lab in virtual time: this one's passes with the clock")
        self.held.hold(pace(factor))

    @property
    def behind_ns(self) -> int:
        """Real time only: how far the buses are behind the clock, a second at most; what is beyond is left out."""
        return 0 if self.pacer is None else self.pacer.behind_ns()

    @property
    def skipped_ns(self) -> int:
        """Real time only: what was left out of time, which this machine could not simulate or was stopped for."""
        return 0 if self.pacer is None else self.pacer.skipped_ns

    def lateness_ns(self) -> list[int]:
        """Real time only: how late each happening was handled."""
        return [] if self.pacer is None else self.pacer.lateness_ns()

    def close(self) -> None:
        """End the lab; a second time does nothing."""
        if self._closed:
            return
        try:
            if self.pacer is not None:
                self.pacer.close()  # before anything is closed: a script whose timer is due still finds its node
        finally:
            self._closed = True
            self._leave()

    def _stalled(self) -> str | None:
        """What is busy and gets nowhere; whoever has buses knows."""
        return None

    def _leave(self) -> None:
        """Whoever has buses closes them."""

    # for buses and nodes

    def soon(self, callback: Callable[[], None]) -> None:
        """Call back at this very time, behind what happens just now. Many at one time share a timer."""
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

    def touch(self) -> AbstractContextManager[None]:
        """Hold the timeline still while it is changed, and let everybody know afterwards."""
        return _UNSHARED if self.pacer is None else self._locked(self.pacer)

    def advance(self, deadline_ns: int, ready: Callable[[], bool]) -> bool:
        """Let time pass until `ready` or the deadline; nodes halt the timeline when something arrives."""
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

    async def turn(self, deadline_ns: int) -> None:
        """Let other tasks have their turn; when none of them did anything, let the next thing happen."""
        import asyncio

        waiter = asyncio.get_running_loop().create_future()
        self.waiters[waiter] = deadline_ns
        try:
            for _ in range(3):
                await asyncio.sleep(0)
                if waiter.done():
                    return
            await self._pass_time(waiter, min(self.waiters.values()))
        finally:
            self.waiters.pop(waiter, None)

    def active(self) -> None:
        """Something happened that a waiting task may be waiting for."""
        if self.waiters:
            for waiter in list(self.waiters):
                waiter.get_loop().call_soon_threadsafe(_resolve, waiter)

    def keeper(self) -> Keeper | None:
        """For canwire.in_time: what lets time pass here, None where the clock does."""
        from canwire.lab.keeper import LabKeeper

        return None if self.pacer is not None else LabKeeper(self.timeline, self.held, self.kick)

    def kick(self) -> None:
        """Time is about to pass; for labs that look at what others have queued."""

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
        """In a forked process a lab in real time is over; one in virtual time is a copy, the child's own."""
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

    @contextlib.contextmanager
    def _locked(self, pacer: Pacer) -> Iterator[None]:
        with pacer.holding():
            pacer.check()
            pacer.catch_up()
            yield
            pacer.wake()


def _resolve(waiter: asyncio.Future[None]) -> None:
    if not waiter.done():
        waiter.set_result(None)


def _never() -> bool:
    return False
