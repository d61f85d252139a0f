"""A timeline at the speed of the wall clock: one engine thread, and its lateness measured."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress

from canwire.errors import CanwireError
from canwire.holding import Hold
from canwire.timeline import NEVER, Timeline

LARGEST_GAP_NS = 1_000_000_000  # what is later than this is left out
SLICE_NS = 4_000_000  # of late happenings, after which callers have their turn
_KEPT = 100_000
_EARLY_NS = 150_000  # operating systems wake sleepers about this much late; what is left over is polled away
_COURTESY_S = 0.02  # how long the engine waits for a caller whom the system does not let run


class Pacer:
    """Runs a timeline so that its nanoseconds pass like the monotonic clock's.

    Code that uses the timeline or anything on it does so in `holding`, and calls `wake` after adding work. Happenings
    that are late run for `SLICE_NS` at most before all callers that wait have had their turn. Once they are later than
    `LARGEST_GAP_NS`, the timeline leaves that time out: it is counted in `skipped_ns`, and `when_late` is called.

    An exception in a callback stops the engine and is raised from `check` and `close`; `when_failed` is called. A
    forked process has no engine: `check` says so. `clock_ns` is for tests.
    """

    def __init__(self, timeline: Timeline, clock_ns: Callable[[], int] = time.monotonic_ns) -> None:
        self.when_failed: Callable[[], object] | None = None
        self.when_late: Callable[[], object] | None = None
        self.skipped_ns = 0
        self._timeline = timeline
        self._stopping = False
        self._forked = False
        self._failure: BaseException | None = None
        self._lateness: list[int] = []
        self._monotonic_ns = clock_ns
        self._origin_ns = clock_ns() - timeline.now_ns
        self._latest_ns = 0  # the reported time never goes backwards
        self._make_locks()
        self._thread = threading.Thread(target=self._run, name="canwire-pacer", daemon=True)
        self._thread.start()

    def now_ns(self) -> int:
        """The timeline's time by the wall clock. While time is left out it does not move."""
        self._latest_ns = max(self._latest_ns, self._clock_ns())
        return self._latest_ns

    def behind_ns(self) -> int:
        """How late the next happening is; 0 if none is due."""
        with self.holding():
            return max(0, self._late_ns())

    def holding(
        self, entered: Callable[[], object] | None = None, leaving: Callable[[], object] | None = None
    ) -> Hold:
        """While held, nothing happens on the timeline. An engine that is late lets all waiting threads run first.

        `entered` is called first, and `leaving` last.
        """
        return Hold(self._lock, self._asked, entered=entered, leaving=leaving or self._let_engine_in)

    def working(self) -> Hold:
        """The same to add work: the time is this moment's, and the engine looks at the timeline again afterwards."""
        return self.holding(self._begin_work, self.wake)

    def _let_engine_in(self) -> None:
        if self._letting_in:
            self._changed.notify_all()

    def _begin_work(self) -> None:
        self.check()
        self.catch_up()

    def catch_up(self) -> None:
        """Bring the timeline's `now_ns` to this moment; in `holding`."""
        if threading.current_thread() is self._thread:
            return  # a callback: the time is that of its happening, however late the clock says it is
        now_ns = self._clock_ns()
        if now_ns > self._timeline.now_ns and self._timeline.next_ns() > now_ns:
            self._timeline.run_until(now_ns)

    def wake(self) -> None:
        """Called in `holding` after something was added to the timeline."""
        self._changed.notify_all()
        self._ring()

    def wait(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """Block until `ready` holds (checked after each happening) or `timeout` seconds are over."""
        deadline = None if timeout is None else time.monotonic() + timeout
        while True:
            bell = threading.Lock()
            with self.holding():
                if self._failure is not None or ready():
                    break
                left = -1.0 if deadline is None else deadline - time.monotonic()
                if deadline is not None and left <= 0:
                    return False
                bell.acquire()
                self._bells.add(bell)
            bell.acquire(timeout=min(left, threading.TIMEOUT_MAX))
            self._bells.discard(bell)
        self.check()
        return True

    def wait_until(self, time_ns: int) -> None:
        """Block until this time has come and everything due by then has happened."""
        while (left_ns := time_ns - self._clock_ns()) > 0 and not self._failed.is_set():
            self._failed.wait(left_ns / 1e9)
        self.wait(lambda: self._timeline.next_ns() > time_ns, None)

    def warn(self) -> None:
        """Log how much time was left out: for `when_late`."""
        import logging  # 10 ms that only those pay who are late

        logging.getLogger("canwire").warning(
            "a lab in real time has left out %.2f s: its buses have more to do than this machine can simulate, "
            "or it was stopped",
            self.skipped_ns / 1e9,
        )

    def lateness_ns(self) -> list[int]:
        """The lateness of the last happenings in nanoseconds, in order."""
        with self.holding():
            return list(self._lateness)

    def check(self) -> None:
        """Raise the error of a callback, if one failed."""
        if self._failure is not None:
            raise self._failure

    def close(self) -> None:
        if self._forked:
            return
        with self.holding():
            self._stopping = True
            self._changed.notify_all()
        self._thread.join()
        self.check()

    def _make_locks(self) -> None:
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)  # the engine alone waits for it
        self._asked: set[Hold] = set()  # who wants to hold the timeline and does not yet
        self._letting_in = False
        self._bells: set[threading.Lock] = set()  # of those in `wait`
        self._failed = threading.Event()

    def _clock_ns(self) -> int:
        return self._monotonic_ns() - self._origin_ns

    def _late_ns(self) -> int:
        return self._clock_ns() - self._timeline.next_ns()

    def _ring(self) -> None:
        with suppress(
            KeyError
        ):  # of an empty set: who has waited long enough takes its own bell away meanwhile
            while True:
                self._bells.pop().release()

    def _run(self) -> None:
        from canwire.platform import (
            sharpen_sleep,  # what knows systems knows sockets, too, which no bench loads
        )

        sharpen_sleep()
        with self._changed:
            while not self._stopping:
                try:
                    self._turn()
                except BaseException as failure:
                    self._fail(failure)
                    if self.when_failed is not None:
                        self.when_failed()
                    return

    def _turn(self) -> None:
        """Run what is due, for a slice of time at most, and let callers in; or sleep until the next happening."""
        late_ns = self._late_ns()
        if late_ns < 0:
            self._changed.wait(None if late_ns < -(NEVER >> 1) else max(0, -late_ns - _EARLY_NS) / 1e9)
            return
        if late_ns > LARGEST_GAP_NS:
            late_ns = self._leave_out(late_ns)
        end_ns = self._monotonic_ns() + SLICE_NS
        while late_ns >= 0 and self._monotonic_ns() < end_ns and not self._stopping:
            if len(self._lateness) < _KEPT:
                self._lateness.append(late_ns)
            self._timeline.run_until(self._timeline.next_ns())
            late_ns = self._late_ns()
        self._ring()
        if late_ns >= 0:
            self._let_in()

    def _leave_out(self, late_ns: int) -> int:
        """Leave the time `late_ns` out and count it as skipped; returns the lateness after that, which is 0."""
        self._origin_ns += late_ns
        self.skipped_ns += late_ns
        if self.when_late is not None:
            self.when_late()
        return 0

    def _let_in(self) -> None:
        """Let all threads that are waiting for the timeline use it before the engine continues."""
        asked = set(self._asked)
        if asked:
            self._letting_in = True
            self._changed.wait_for(lambda: asked.isdisjoint(self._asked), _COURTESY_S)
            self._letting_in = False

    def _fail(self, failure: BaseException) -> None:
        self._failure = failure
        self._failed.set()
        self._ring()

    def leave_to_parent(self) -> None:
        """In a forked child: the engine belongs to the parent, and the holders of the locks do not exist here."""
        self._make_locks()
        self._stopping = self._forked = True
        self._fail(CanwireError("this lab belongs to the process that was forked; make another in this one"))
