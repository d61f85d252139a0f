"""Waiting for descriptors: for any of some, and for an event until something is settled."""

from __future__ import annotations

import contextlib
import select
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator

_wake_up: socket.socket | None = None  # readable once a signal has come, while `signals_end_waits`


def wait_readable(descriptors: list[int], timeout: float | None) -> bool:
    """Block until one of them is readable, `timeout` seconds at most (None: for ever); False when time is over."""
    wake_up = _wake_up
    if wake_up is None or timeout == 0 or threading.current_thread() is not threading.main_thread():
        return _any_readable(descriptors, timeout)
    deadline = None if timeout is None else time.monotonic() + timeout
    left = timeout
    while _any_readable([wake_up.fileno(), *descriptors], left):
        with contextlib.suppress(BlockingIOError):
            wake_up.recv(_MANY)  # the handler runs now, and may raise
        if _any_readable(descriptors, 0):
            return True
        left = None if deadline is None else max(0.0, deadline - time.monotonic())
    return False


def hears_signals() -> bool:
    """This thread's waits are within `signals_end_waits`."""
    return _wake_up is not None and threading.current_thread() is threading.main_thread()


@contextlib.contextmanager
def signals_end_waits() -> Iterator[None]:
    """For programs with handlers of their own that raise, or set what is waited for: none comes too late for a wait.

    Python runs a signal's handler when it next looks. A signal between its last look and the system's wait (some ten
    microseconds) would be heard only when that wait is over: never, where it has no timeout. Within this context all
    waits of the main thread for frames, messages and events hear of signals whenever they come. Takes the place of
    signal.set_wakeup_fd meanwhile. Elsewhere than in the main thread, which alone hears signals, it does nothing.
    """
    global _wake_up
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heard, told = _pair()
    with heard, told:
        descriptor = signal.set_wakeup_fd(told.fileno(), warn_on_full_buffer=False)
        before, _wake_up = _wake_up, heard
        try:
            yield
        finally:
            _wake_up = before
            signal.set_wakeup_fd(descriptor)


def _pair() -> tuple[socket.socket, socket.socket]:
    """What goes into the second comes out of the first; neither blocks."""
    if not hasattr(socket, "socketpair"):
        from canwire.platform.portable.pairs import connected_pair

        return connected_pair()
    pair = socket.socketpair()
    for end in pair:
        end.setblocking(False)
    return pair


def _any_readable(descriptors: list[int], timeout: float | None) -> bool:
    if (
        sys.platform == "win32" or max(descriptors) < _SELECTABLE
    ):  # the quicker one, and it counts microseconds
        return bool(select.select(descriptors, [], [], timeout)[0])
    poll = select.poll()
    for descriptor in descriptors:
        poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(None if timeout is None else timeout * 1000))


class Waiting:
    """What can be waited for again and again."""

    def wait(self, timeout: float | None = None) -> bool:
        """Consume a signal, waiting `timeout` seconds for it (None: for ever); False when none came."""
        raise NotImplementedError

    def rest(self) -> None:
        """`wait` for ever, by the one thread of the one process that ever consumes these signals."""
        self.wait()

    def wait_for(
        self, settled: Callable[[], bool], timeout: float | None, recheck: float | None = None
    ) -> bool:
        """Wait for signals until `settled()`, which is asked after each, is True; False once the time is over.

        `recheck` asks it every so many seconds even without a signal.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        while not settled():
            left = None if deadline is None else deadline - time.monotonic()
            if left is not None and left <= 0:
                return False
            self.wait(left if recheck is None else min(recheck, recheck if left is None else left))
        return True


_MANY = 4096
_SELECTABLE = 1024  # select knows no descriptor from here up, but on Windows, where the number says nothing
