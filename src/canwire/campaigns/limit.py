"""The time that a run may take: it is ended in the thread that plays it, or else its process is."""

from __future__ import annotations

import contextlib
import faulthandler
import os
from collections.abc import Iterator

from canwire.errors import BadValue
from canwire.platform.time_limit import interrupted_after

GRACE_S = 1.0  # what a run's own `finally` may take before its process is ended
MOST_S = 1e6


class TooLong(BaseException):
    """Raised in a run that has taken longer than it may. No Exception: scripts catch those."""


def limit_of(seconds: float | None) -> float | None:
    """Seconds a run may take, 0.001 to 1,000,000, None: any; raises BadValue."""
    if seconds is not None and not 0.001 <= seconds <= MOST_S:
        raise BadValue(f"time limit {seconds}: 0.001 to 1,000,000 seconds for each run")
    return seconds


@contextlib.contextmanager
def at_most(limit_s: float | None) -> Iterator[None]:
    """What runs in this thread is ended by TooLong after so many seconds (None: never).

    That comes between two steps of Python: compiled code that never returns to it is not ended, which is what
    `process_at_most` is for.
    """
    if limit_s is None:
        yield
        return
    with interrupted_after(limit_s, TooLong):
        yield


@contextlib.contextmanager
def process_at_most(limit_s: float | None, grace_s: float = GRACE_S) -> Iterator[None]:
    """This process ends if what runs in it is not over after so many seconds and `grace_s` (None: never)."""
    if limit_s is None:
        yield
        return
    with open(os.devnull, "w") as nowhere:
        faulthandler.dump_traceback_later(limit_s + grace_s, exit=True, file=nowhere)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()
