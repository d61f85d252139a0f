"""Waiting for any of several descriptors, and for an event until a condition is true."""

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
    """Block until one of them is readable, `timeout` seconds at most (None: forever); False if none is by then."""
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
    """Whether the waits of this thread are within `signals_end_waits`."""
    return _wake_up is not None and threading.current_thread() is threading.main_thread()


@contextlib.contextmanager
def signals_end_waits() -> Iterator[None]:
    """For programs whose signal handlers raise or end a wait: within this context, every signal ends the wait in time.

    Python runs the handler of a signal at its next check. A signal between the last check and the system's wait (some
    ten microseconds) would be handled only after that wait, and never if the wait has no timeout. Within this context
    signals interrupt all waits of the main thread for frames, messages and events. It uses signal.set_wakeup_fd
    meanwhile. In other threads, which receive no signals, it does nothing.
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
    """Two sockets: the first receives what the second sends; neither blocks."""
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
    """An object that can be waited for repeatedly."""

    def wait(self, timeout: float | None = None) -> bool:
        """Consume a signal, waiting at most `timeout` seconds for it (None: forever); False if none came."""
        raise NotImplementedError

    def rest(self) -> None:
        """`wait` without a timeout, in the only thread of the only process that consumes these signals."""
        self.wait()

    def wait_for(
        self, settled: Callable[[], bool], timeout: float | None, recheck: float | None = None
    ) -> bool:
        """Wait for signals until `settled()`, called after each signal, is True; False if the time is over before.

        With `recheck` it is also called every `recheck` seconds without a signal.
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
