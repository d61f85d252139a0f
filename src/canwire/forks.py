"""What a fork leaves to the process that forked: things that hear of it in the child before all else."""

from __future__ import annotations

import os
from typing import Protocol
from weakref import WeakSet


class Forked(Protocol):
    """What belongs to the process that made it. `leave_to_parent` takes no lock: its holder may not be there."""

    def leave_to_parent(self) -> None:
        """In the child: say so at each use from now on, and take and write nothing that is the parent's."""


class HasFileno(Protocol):
    """A file of the system's."""

    def fileno(self) -> int: ...


def hear_of_forks(thing: Forked) -> None:
    """Call its `leave_to_parent` in every child that is forked while it lives."""
    _LIVING.add(thing)


def lead_nowhere(file: HasFileno) -> None:
    """In the child: what this file still writes, when it is collected, does not come into the parent's."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, file.fileno(), inheritable=False)
    os.close(nowhere)


def reopen(file: HasFileno) -> None:
    """In the child: a place in the file of its own, where both would go on from the one that the other has left.

    Raises OSError where the system does not open it anew.
    """
    number = file.fileno()
    place = os.lseek(number, 0, os.SEEK_CUR)
    anew = os.open(f"/proc/self/fd/{number}", os.O_RDONLY)
    os.lseek(anew, place, os.SEEK_SET)
    os.dup2(anew, number, inheritable=False)
    os.close(anew)


_LIVING: WeakSet[Forked] = WeakSet()


def _after_fork() -> None:
    for thing in list(_LIVING):
        thing.leave_to_parent()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
