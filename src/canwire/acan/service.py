"""The service thread: it handles what arrives from the bus, and wakes the threads that wait for it.

On a hub in virtual time no such thread runs: the thread that waits does its work, and time passes while it waits.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire import Event, InUse

if TYPE_CHECKING:
    from canwire import Hub
    from canwire.acan.task_block import TaskBlock


_PAUSES_S = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)  # a line is set up in much less


class Service:
    """Runs `work` each time `event` is signalled, until `work` returns False, which it must do after `stop`.

    A thread that changes what others wait for holds `lock`; `wait` releases the lock while it waits.
    """

    def __init__(self, hub: Hub, name: str, work: Callable[[], bool]) -> None:
        self.event = Event()
        self.lock = threading.RLock()
        self.sending = threading.Lock()  # one sender at a time
        self._hub = hub
        self._work = work
        self._changed = threading.Condition(self.lock)
        self._over = self._stopped_here = False
        self._thread = None if hub.virtual else threading.Thread(target=self._run, name=name, daemon=True)

    @property
    def here(self) -> bool:
        """Whether the thread that waits does the work itself, as on a hub in virtual time."""
        return self._thread is None

    def start(self) -> None:
        if self._thread is not None:
            self._thread.start()

    def changed(self) -> None:
        """Have each waiting thread check its condition again."""
        with self.lock:
            self._changed.notify_all()

    def wait(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """Wait for ready(), which may raise, for `timeout` seconds of the hub's time (None: without limit)."""
        if self._thread is None:
            return self._wait_here(ready, timeout)
        with self.lock:
            return self._changed.wait_for(ready, timeout)

    def stop(self) -> None:
        """End the thread and wait for its end; called on that thread, it does not wait. A second call does nothing."""
        if not self._over:
            self._over = True
            self.event.set()
            self._stopped_here = self._thread is threading.current_thread()
            if self._thread is not None and not self._stopped_here:
                self._thread.join()
            self.changed()

    def close(self) -> None:
        """Close the event; call it after `stop`, when the event is assigned to no channel."""
        if self._thread is not threading.current_thread():  # else it does that itself
            self.event.close()

    def _run(self) -> None:
        while self._work():
            self.event.wait()
        if self._stopped_here:
            self.event.close()

    def _wait_here(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        end_ns = None if timeout is None else self._hub.now_ns() + round(timeout * 1e9)
        while True:
            self._work()
            if ready():
                return True
            left = None if end_ns is None else max(0, end_ns - self._hub.now_ns()) / 1e9
            if left == 0 or not self.event.wait(left):
                self._work()
                return ready()


def patiently(hub: Hub, call: Callable[[], object]) -> None:
    """Run `call`, and again while it raises InUse, since programs configure a line one after the other."""
    for pause_s in _PAUSES_S:
        try:
            call()
            return
        except InUse:
            hub.sleep(pause_s)
    call()


def notify(block: TaskBlock) -> None:
    """Notify an application. threading.excepthook reports what its code raises, and the service continues."""
    try:
        block.notify()
    except Exception:
        kind, error, trace = sys.exc_info()
        assert kind is not None
        threading.excepthook(threading.ExceptHookArgs((kind, error, trace, threading.current_thread())))
