"""What this process has open: nothing is left behind by programs that ended, or that nobody holds any more."""

from __future__ import annotations

import gc
import os
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tests import warm
from tests.hubs import LONG_S

_OPEN = Path("/proc/self/fd")
_STANDARD = 2
GIVES_BACK = "canwire-forgotten"  # the thread that closes a hub which nobody holds


def open_descriptors() -> Counter[str]:
    """By what they are; empty where the system does not tell."""
    gc.collect()
    for thread in threading.enumerate():
        if thread.name == GIVES_BACK:
            thread.join(LONG_S)
    gc.collect()
    found: Counter[str] = Counter()
    for name in os.listdir(_OPEN) if _OPEN.exists() else ():
        if int(name) <= _STANDARD:  # pytest's capturing changes what these are
            continue
        with suppress(OSError):  # the listing's own
            found[os.readlink(_OPEN / name).partition(":[")[0]] += 1
    return found


def descriptors_before() -> Counter[str]:
    """What is open before a test.

    The collector leaves alone what is there by now: else each collection walks through all tests of the session.
    """
    gc.freeze()
    return open_descriptors()


def left_open(look: Callable[[], Counter[str]]) -> Counter[str]:
    """What `look` finds too much; it looks again with all that there is collected before it says so."""
    found = look()
    if found:
        gc.unfreeze()
        found = look()
        gc.freeze()  # else all later collections walk through all tests
    return found


@contextmanager
def nothing_left_open() -> Iterator[None]:
    warm.ready()
    before = descriptors_before()
    yield
    left = left_open(lambda: open_descriptors() - before)
    assert not left, f"left open: {dict(left)}"
