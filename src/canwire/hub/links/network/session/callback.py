"""Callbacks of Zenoh: its threads call directly into Python, and each stays registered with the interpreter."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable
from typing import Any

from canwire.hub.links.network.session.settings import load_zenoh


class _Known(threading.local):
    """Part of the interpreter's record of a thread, and removed with it."""

    kept = False


_known = _Known()


def direct(work: Callable[[Any], object]) -> Any:
    """A handler for Zenoh that calls `work` in the receiving thread: `work` must not wait.

    A thread that the interpreter did not start gets a record for each call otherwise, with a stack that the system
    maps and unmaps again: half of what a batch of frames costs.
    """

    def call(what: Any) -> None:
        if not _known.kept:
            _known.kept = True
            ctypes.pythonapi.PyGILState_Ensure()  # never released: the record stays until the thread ends
        work(what)

    return load_zenoh().handlers.Callback(call, indirect=False)
