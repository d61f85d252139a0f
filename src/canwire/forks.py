"""Objects that belong to the process that forked: the child calls their `leave_to_parent` first of all."""

from __future__ import annotations

import os
from typing import Protocol
from weakref import WeakSet


class Forked(Protocol):
    """An object of the process that made it. `leave_to_parent` takes no lock: no thread of the child may hold it."""

    def leave_to_parent(self) -> None:
        """In the child: raise an error at each later use, and read and write nothing of the parent."""


class HasFileno(Protocol):
    """A file with a descriptor."""

    def fileno(self) -> int: ...


def hear_of_forks(thing: Forked) -> None:
    """In every child that is forked while `thing` exists, call its `leave_to_parent`."""
    _LIVING.add(thing)


def lead_nowhere(file: HasFileno) -> None:
    """In the child: redirect the file's descriptor to the null device: its writes no longer reach the parent's file."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, file.fileno(), inheritable=False)
    os.close(nowhere)


def reopen(file: HasFileno) -> None:
    """In the child: get a separate file position, since parent and child would share one.

    Raises OSError if the system cannot reopen the file.
    """
    number = file.fileno()
    place = os.lseek(number, 0, os.SEEK_CUR)
    reopened = os.open(f"/proc/self/fd/{number}", os.O_RDONLY)
    os.lseek(reopened, place, os.SEEK_SET)
    os.dup2(reopened, number, inheritable=False)
    os.close(reopened)


_LIVING: WeakSet[Forked] = WeakSet()


def _after_fork() -> None:
    for thing in list(_LIVING):
        thing.leave_to_parent()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
