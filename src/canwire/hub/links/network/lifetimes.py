"""The open links: how they end in a fork of this process, and when the process ends."""

from __future__ import annotations

import atexit
import os
import weakref
from typing import Protocol


class Living(Protocol):
    """The methods of client.py's links that are called at the end."""

    def leave_to_parent(self) -> None: ...
    def close(self) -> None: ...


LIVING: weakref.WeakSet[Living] = weakref.WeakSet()


def _after_fork() -> None:
    for link in list(LIVING):
        link.leave_to_parent()


def _at_exit() -> None:
    """Zenoh's threads must not call into an interpreter that has ended."""
    for link in list(LIVING):
        link.close()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
atexit.register(_at_exit)
