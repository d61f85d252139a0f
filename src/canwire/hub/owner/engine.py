"""Runs the world of a hub: one thread for its time, its input and all requests."""

from __future__ import annotations

import os
import sys
import threading
import traceback
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from canwire.errors import BadValue, CanwireError, HubLost
from canwire.hub.owner.held.bells import Bells
from canwire.hub.owner.lockstep.pace import LockstepPace
from canwire.hub.owner.loop import HasFileno, Loop
from canwire.hub.owner.pace import FastPace, RealPace
from canwire.hub.protocol.pending import Pending

if TYPE_CHECKING:
    from canwire.hub.owner.world import World

Result = TypeVar("Result")

REAL, FAST, VIRTUAL, LOCKSTEP = "real", "fast", "virtual", "lockstep"
_PACES: dict[str, Callable[[World], RealPace]] = {REAL: RealPace, FAST: FastPace, LOCKSTEP: LockstepPace}


class Engine:
    """Owns a world. In "virtual" time the calling threads run it, one at a time; else one thread of the engine does.

    All access to the world is by `call` or `post`, or by a callback given to `watch`, so that only one runs at a time.
    A callback that raises is reported on stderr, once for each place, and counted in `failures`; the engine continues.
    """

    def __init__(self, world: World, time: str = REAL, pace: RealPace | None = None) -> None:
        if time not in (*_PACES, VIRTUAL):
            raise BadValue(f"time {time!r}: one of real, fast, virtual, lockstep")
        self.world = world
        self.time = time
        self.failures = 0
        self._reported: set[str] = set()
        self._posted: deque[Callable[[], object]] = deque()
        self._when_closed: list[Callable[[], object]] = []
        self._closed = False
        self._pid = os.getpid()
        self._lock = threading.RLock()  # in virtual time the thread that has the world holds it
        self._calls = 0
        if pace is None and time in (REAL, FAST):
            world.bells = Bells()
        self._loop = None if time == VIRTUAL else Loop(self, pace or _PACES[time](world), self._posted)
        if self._loop is not None:
            if world.reactor is not None:
                world.reactor.attach(self)
            self._loop.thread.start()

    @property
    def closed(self) -> bool:
        """True if the engine was closed, or if this process is a fork of the engine's process."""
        return self._closed or self._pid != os.getpid()

    def call(self, work: Callable[[], Result]) -> Result:
        """Call `work` with the world; returns and raises what `work` does, raises HubLost once closed."""
        if self._loop is None:
            return self._call_here(work)
        if self.inside():
            return work()
        done: Pending[Result] = Pending()
        self._hand_over(lambda: self._answer(work, done))
        return done.result()

    def post(self, work: Callable[[], object]) -> None:
        """Call `work` with the world soon, after the present call; no effect once closed."""
        if self.inside():
            self._posted.append(work)
        elif not self.closed:
            self._hand_over(work)

    def inside(self) -> bool:
        """True in the engine's thread."""
        return self._loop is not None and threading.current_thread() is self._loop.thread

    def watch(
        self, source: HasFileno, readable: Callable[[], object], writable: Callable[[], object] | None = None
    ) -> None:
        """Call back whenever `source` is readable, or writable; a second call replaces these. Engine's thread only.

        In virtual time nothing is watched: the thread that lets time pass checks everything.
        """
        if self._loop is not None:
            self._loop.watch(source, readable, writable)

    def unwatch(self, source: HasFileno) -> None:
        """Stop watching immediately; an unknown source is ignored. Call this before `source` is closed."""
        if self._loop is not None:
            self._loop.unwatch(source)

    def remind(self, seconds: float, work: Callable[[], object]) -> None:
        """Call back once after this many seconds of the monotonic clock, not of bus time. Engine's thread only.

        The callback is not called in virtual time, nor once closed.
        """
        if self._loop is not None:
            self._loop.remind(seconds, work)

    def when_closed(self, callback: Callable[[], object]) -> None:
        """Call back when the engine closes, in the engine's thread."""
        self._when_closed.append(callback)

    def forget(self, callback: Callable[[], object]) -> None:
        """Remove a callback of `when_closed`; an unknown one is ignored."""
        if callback in self._when_closed:
            self._when_closed.remove(callback)

    def lateness_ns(self) -> list[int]:
        """The delays of the last events of the timeline, in order; [] in virtual time."""
        return [] if self._loop is None else list(self._loop.pace.lateness_ns)

    def report(self, error: BaseException) -> None:
        """Count a failure of the hub itself, and print it unless one from the same place was printed before."""
        self.failures += 1
        frames = traceback.extract_tb(error.__traceback__)
        place = (
            f"{type(error).__name__} at {frames[-1].filename}:{frames[-1].lineno}" if frames else repr(error)
        )
        if place not in self._reported:
            self._reported.add(place)
            text = "".join(traceback.format_exception(error))
            print(f"canwire hub: a failure (reported once):\n{text}", file=sys.stderr, flush=True)

    def close(self, *, tell: bool = True) -> None:
        """Stop after all earlier calls are done. A second call has no effect.

        Without `tell` no `when_closed` callback is called: at the end of a process no thread is left to be woken.
        """
        if self.closed:
            return
        if not tell:
            self._when_closed.clear()
        if self._loop is None:
            self._call_here(self.finish)
        else:
            with self._lock:  # once `finish` has had it, the loop closes what is signalled here
                self._loop.stopping = True
                if not self._closed:
                    self._loop.wake.signal()
            if not self.inside():
                self._loop.thread.join()

    # for the loop

    def attempt(self, work: Callable[[], object]) -> bool:
        """Call `work`; False if it raised."""
        try:
            work()
        except Exception as error:
            self.report(error)
            return False
        return True

    def run_posted(self) -> None:
        """Do all work posted up to now; work that it posts has to wait."""
        for _ in range(len(self._posted)):
            self.attempt(self._posted.popleft())

    def finish(self) -> None:
        """The end: every waiting call gets an answer, and no new call is accepted."""
        with self._lock:
            self._closed = True
        while self._posted:
            self.run_posted()
        for callback in list(self._when_closed):
            self.attempt(callback)

    def _call_here(self, work: Callable[[], Result]) -> Result:
        with self._lock:
            self._check()
            self._calls += 1
            try:
                return work()
            finally:
                while self._posted and self._calls == 1:
                    self.run_posted()
                self._calls -= 1

    def _hand_over(self, work: Callable[[], object]) -> None:
        with self._lock:
            self._check()
            self._posted.append(work)
            if self._loop is None and self._calls == 0:
                self._call_here(lambda: None)
            elif self._loop is not None:
                self._loop.wake.signal()

    def _check(self) -> None:
        if self._pid != os.getpid():
            raise CanwireError("this hub belongs to the process that was forked; connect again in this one")
        if self._closed:
            raise HubLost("the hub in this process was closed")

    @staticmethod
    def _answer(work: Callable[[], Result], done: Pending[Result]) -> None:
        try:
            done.settle(work())
        except BaseException as error:
            done.fail(error)
