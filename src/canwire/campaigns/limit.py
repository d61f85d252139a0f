"""Limits the time of a run, by an exception in its thread or by the end of its process."""

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
    """Raised in a run that exceeds its time limit. It is no Exception, because scripts catch those."""


def limit_of(seconds: float | None) -> float | None:
    """Return a valid time limit: 0.001 to 1,000,000 seconds for each run, or None for no limit. Raises BadValue."""
    if seconds is not None and not 0.001 <= seconds <= MOST_S:
        raise BadValue(f"time limit {seconds}: 0.001 to 1,000,000 seconds for each run")
    return seconds


@contextlib.contextmanager
def at_most(limit_s: float | None) -> Iterator[None]:
    """Raise TooLong in this thread if the `with` block takes longer than `limit_s` seconds (None: no limit).

    The exception is raised between two bytecodes of Python, so it does not end compiled code that never returns;
    `process_at_most` does."""
    if limit_s is None:
        yield
        return
    with interrupted_after(limit_s, TooLong):
        yield


@contextlib.contextmanager
def process_at_most(limit_s: float | None, grace_s: float = GRACE_S) -> Iterator[None]:
    """End this process if the `with` block takes longer than `limit_s` + `grace_s` seconds (None: no limit)."""
    if limit_s is None:
        yield
        return
    with open(os.devnull, "w") as nowhere:
        faulthandler.dump_traceback_later(limit_s + grace_s, exit=True, file=nowhere)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()
