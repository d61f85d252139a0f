"""Threads that wait for what a handle's channel brings: one of them sleeps, and wakes the others.

No thread of its own: whoever waits looks at what has come, for everybody. On a hub in virtual time waiting lets that
time pass.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire import Event
from canwire.candrv.constants import Win32Error
from canwire.candrv.errors import CandrvError

if TYPE_CHECKING:
    from canwire import Hub, HubChannel


class WaitingRoom:
    """`lock` is over everything that the threads share; `until` gives it up while it sleeps.

    `arm` has `event` signalled by the next thing that comes, or at once if something came since the last look.
    """

    def __init__(self, hub: Hub) -> None:
        self.lock = threading.Lock()
        self.event = Event()
        self._hub = hub
        self._changed = threading.Condition(self.lock)
        self._deadlines: list[int] = []
        self._waiting = 0
        self._sleeps = False
        self._closed = False

    def deadline(self, timeout: float | None) -> int | None:
        """When so many seconds of the hub's time are over, in ns; None: never."""
        return None if timeout is None else self._now() + round(timeout * 1e9)

    def passed(self, deadline: int | None) -> bool:
        """The time is over."""
        return deadline is not None and self._now() >= deadline

    def until(self, ready: Callable[[], bool], deadline: int | None, arm: Callable[[], object]) -> bool:
        """Wait until ready(), which may raise, at most until the deadline; was it? The caller holds the lock."""
        if ready():
            return True
        self._waiting += 1
        if deadline is not None:
            self._deadlines.append(deadline)
        try:
            while True:
                left = None if deadline is None else deadline - self._now()
                if left is not None and left <= 0:
                    return ready()
                arm()
                self._sleep(None if left is None else left / 1e9)
                if ready():
                    return True
        finally:
            self._waiting -= 1
            if deadline is not None:
                self._deadlines.remove(deadline)
            if self._closed and not self._waiting:
                self.event.close()

    def wake(self) -> None:
        """Something changed: let those who wait look again. The caller holds the lock."""
        if self._waiting:
            self.event.set()
            self._changed.notify_all()

    def close(self) -> None:
        """Wake everybody for the last time; what they wait for has to raise. The caller holds the lock."""
        self.wake()
        if not self._closed:
            self._closed = True
            if not self._waiting:
                self.event.close()

    def _sleep(self, left: float | None) -> None:
        if self._hub.timed:
            self._await_turn(left)
            return
        virtual = self._hub.virtual
        if self._sleeps:
            self._changed.wait(None if virtual else left)
            return
        if virtual and self._deadlines:
            left = max(0, min(self._deadlines) - self._now()) / 1e9
        self._sleeps = True
        try:  # a signal's exception may come behind each call here, and must leave the lock held
            self.lock.release()
            self.event.wait(left)
        finally:
            try:
                self.lock.acquire()
            finally:
                self._sleeps = False
                self._changed.notify_all()

    def _await_turn(self, left: float | None) -> None:
        """One time with other programs: each thread waits for itself, since time waits for each."""
        try:
            self.lock.release()
            if not self.event.is_set():
                self._hub.wait_once(left)
            self.event.reset()
        finally:
            self.lock.acquire()

    def _now(self) -> int:
        return self._hub.now_ns() if self._hub.virtual else time.monotonic_ns()


def timed_out(channel: HubChannel, device: str, what: str) -> CandrvError:
    """ERROR_TIMEOUT, with what keeps a real adapter off its bus where that is the reason."""
    why = channel.hub.line_status(channel.board, channel.line).obstacle
    return CandrvError(Win32Error.ERROR_TIMEOUT, f"{device} {what}{f': {why}' if why else ''}")
