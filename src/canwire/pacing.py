"""A timeline at the speed of the wall clock: one engine thread, and its lateness measured."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from canwire.timeline import NEVER, Timeline

_KEPT = 100_000
_EARLY_NS = 150_000  # operating systems wake sleepers about this much late; what is left over is polled away


class Pacer:
    """Runs a timeline so that its nanoseconds pass like the monotonic clock's.

    Whoever touches the timeline or anything on it holds `lock`, and calls `wake` after adding work.
    An exception in a callback stops the engine and is raised from `check` and `close`; `when_failed` is called.
    """

    def __init__(self, timeline: Timeline) -> None:
        self.lock = threading.RLock()
        self.when_failed: Callable[[], object] | None = None
        self._timeline = timeline
        self._changed = threading.Condition(self.lock)
        self._stopping = False
        self._failure: BaseException | None = None
        self._failed = threading.Event()
        self._lateness: list[int] = []
        self._origin_ns = time.monotonic_ns() - timeline.now_ns
        self._thread = threading.Thread(target=self._run, name="canwire-pacer", daemon=True)
        self._thread.start()

    def now_ns(self) -> int:
        """The timeline's time by the wall clock."""
        return time.monotonic_ns() - self._origin_ns

    def catch_up(self) -> None:
        """Bring the timeline's `now_ns` to this moment; hold `lock`."""
        if threading.current_thread() is self._thread:
            return  # a callback: the time is that of its happening, however late the clock says it is
        now_ns = self.now_ns()
        if now_ns > self._timeline.now_ns and self._timeline.next_ns() > now_ns:
            self._timeline.run_until(now_ns)

    def wake(self) -> None:
        """Something was added to the timeline; hold `lock`."""
        self._changed.notify_all()

    def wait(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """Block until `ready` holds (looked at after every happening) or `timeout` seconds are over."""
        with self._changed:
            met = self._changed.wait_for(lambda: self._failure is not None or ready(), timeout)
        self.check()
        return met

    def wait_until(self, time_ns: int) -> None:
        """Block until this time has come and everything due by then has happened."""
        while (left_ns := time_ns - self.now_ns()) > 0 and not self._failed.is_set():
            self._failed.wait(left_ns / 1e9)
        self.wait(lambda: self._timeline.next_ns() > time_ns, None)

    def lateness_ns(self) -> list[int]:
        """How late the last happenings were, in order."""
        with self.lock:
            return list(self._lateness)

    def check(self) -> None:
        """Raise what went wrong in a callback, if anything did."""
        if self._failure is not None:
            raise self._failure

    def close(self) -> None:
        with self._changed:
            self._stopping = True
            self._changed.notify_all()
        self._thread.join()
        self.check()

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
                    self._failure = failure
                    self._failed.set()
                    self._changed.notify_all()
                    if self.when_failed is not None:
                        self.when_failed()
                    return

    def _turn(self) -> None:
        """Run what is due, then sleep until the next happening or a change."""
        due_ns = self._timeline.next_ns()
        late_ns = self.now_ns() - due_ns
        if late_ns >= 0:
            if len(self._lateness) < _KEPT:
                self._lateness.append(late_ns)
            self._timeline.run_until(due_ns)
            self._changed.notify_all()
        else:
            self._changed.wait(None if due_ns >= NEVER else max(0, -late_ns - _EARLY_NS) / 1e9)
