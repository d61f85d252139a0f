"""Waiting for descriptors: for any of some, and for an event until something is settled."""

from __future__ import annotations

import select
import sys
import time
from collections.abc import Callable


def wait_readable(descriptors: list[int], timeout: float | None) -> bool:
    """Block until one of them is readable, `timeout` seconds at most (None: for ever); False when time is over."""
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


_SELECTABLE = 1024  # select knows no descriptor from here up, but on Windows, where the number says nothing
