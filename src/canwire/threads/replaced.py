"""The replacements for the standard library while threads take turns, and the places of the originals."""

from __future__ import annotations

import queue
import select
import selectors
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import ModuleType, SimpleNamespace
from typing import Any

from canwire.threads import clocks, descriptors, originals, thread
from canwire.threads.lock import Lock

_KEPT = {  # modules that always use real time: they wait for other processes, or measure tests
    "_pytest", "_thread", "builtins", "canwire", "coverage", "debugpy", "execnet", "multiprocessing", "pluggy",
    "pydevd", "pytest", "pytest_timeout", "select", "subprocess", "time", "xdist",
}  # fmt: skip


class Replaced:
    """The first `begin` puts the replacements in place, the last `end` restores the originals."""

    def __init__(self) -> None:
        self._users = 0
        self._lock = originals.allocate_lock()
        self._back: list[Callable[[], object]] = []

    def begin(self) -> None:
        with self._lock:
            self._users += 1
            if self._users == 1:
                self._put()

    def end(self) -> None:
        with self._lock:
            self._users -= 1
            if self._users == 0:
                while self._back:
                    self._back.pop()()

    def _put(self) -> None:
        functions = _functions()
        for module in list(sys.modules.values()):
            if isinstance(module, ModuleType) and module.__name__.partition(".")[0] not in _KEPT:
                self._put_into(module, functions)
        for owner, name, new in _places():
            self._set(owner, name, new)

    def _put_into(self, module: ModuleType, functions: dict[int, Any]) -> None:
        """Replace the names that a module has imported: `from time import sleep`."""
        for name, value in list(vars(module).items()):
            new = functions.get(id(value))
            if new is not None:
                self._set(module, name, new)

    def _set(self, owner: Any, name: str, new: Any) -> None:
        before = getattr(owner, name)
        setattr(owner, name, new)
        self._back.append(lambda: setattr(owner, name, before))


def _functions() -> dict[int, Any]:
    """Return the replacements by the id of the original."""
    return {
        id(before): new
        for before, new in (
            (originals.sleep, clocks.sleep),
            (originals.monotonic, clocks.monotonic),
            (originals.monotonic_ns, clocks.monotonic_ns),
            (originals.perf_counter, clocks.perf_counter),
            (originals.perf_counter_ns, clocks.perf_counter_ns),
            (originals.time_s, clocks.time_s),
            (originals.time_ns, clocks.time_ns),
            (originals.allocate_lock, Lock),
            (originals.new_reentrant_lock, threading._PyRLock),  # type: ignore[attr-defined]
            (originals.simple_queue, queue._PySimpleQueue),  # type: ignore[attr-defined]
            (originals.select_select, descriptors.select),
        )
    }


def _places() -> Iterator[tuple[Any, str, Any]]:
    """Yield the places other than imported names: owner, attribute, replacement."""
    for name in ("sleep", "monotonic", "monotonic_ns", "perf_counter", "perf_counter_ns", "time_ns"):
        yield time, name, getattr(clocks, name)
    yield time, "time", clocks.time_s
    yield threading.Thread, "start", thread.start
    yield threading.Thread, "join", thread.join
    yield threading.Thread, "is_alive", thread.is_alive
    yield select, "select", descriptors.select
    if originals.select_poll is not None:
        yield select, "poll", descriptors.Poll
    for kind, method in originals.select_of.items():
        yield kind, "select", descriptors.selecting(method)
    yield subprocess, "time", SimpleNamespace(sleep=originals.sleep, monotonic=originals.monotonic)
    if hasattr(subprocess, "_PopenSelector"):
        yield subprocess, "_PopenSelector", _by_the_clock(subprocess._PopenSelector)


def _by_the_clock(kind: type[selectors.BaseSelector]) -> type[selectors.BaseSelector]:
    """Return a selector class with the original `select`, for waits for another process in real time."""
    select_there = next(originals.select_of[base] for base in kind.__mro__ if base in originals.select_of)
    return type(kind.__name__, (kind,), {"select": select_there})


REPLACED = Replaced()
