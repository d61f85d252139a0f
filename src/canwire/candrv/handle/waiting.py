"""Threads that wait for records of a handle's channel: one of them sleeps on the channel's event, and wakes the others.

A handle has no service thread: a thread that waits handles the records for all. On a hub in virtual time, time passes
while a thread waits.
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
    """`lock` protects everything that the threads share; `until` releases it while it sleeps.

    `arm` makes the next record signal `event`; it signals it immediately if a record has arrived since the last check.
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
        """The time in ns at which `timeout` seconds of the hub's time are over; None: no deadline."""
        return None if timeout is None else self._now() + round(timeout * 1e9)

    def passed(self, deadline: int | None) -> bool:
        """Whether the deadline has passed."""
        return deadline is not None and self._now() >= deadline

    def until(self, ready: Callable[[], bool], deadline: int | None, arm: Callable[[], object]) -> bool:
        """Wait for ready(), which may raise, until the deadline; returns its result. The caller holds the lock."""
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
        """After a change: have the waiting threads check again. The caller holds the lock."""
        if self._waiting:
            self.event.set()
            self._changed.notify_all()

    def close(self) -> None:
        """Wake all threads for the last time; their ready() must raise then. The caller holds the lock."""
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
        try:  # a signal may raise after each of these calls, and the lock must then be held
            self.lock.release()
            self.event.wait(left)
        finally:
            try:
                self.lock.acquire()
            finally:
                self._sleeps = False
                self._changed.notify_all()

    def _await_turn(self, left: float | None) -> None:
        """In lockstep: each thread waits on its own, since the hub's time waits for each of them."""
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
    """ERROR_TIMEOUT, with the obstacle that keeps a real adapter off its bus, if there is one."""
    why = channel.hub.line_status(channel.board, channel.line).obstacle
    return CandrvError(Win32Error.ERROR_TIMEOUT, f"{device} {what}{f': {why}' if why else ''}")
