"""Child processes and parents, from /proc (proc_pid_stat(5))."""

from __future__ import annotations

import os


def children_of(process: int) -> list[int]:
    """The direct children of a process, including ended ones that it has not waited for."""
    return [
        number
        for number in map(int, filter(str.isdigit, os.listdir("/proc")))
        if parent_of(number) == process
    ]


def is_below(process: int, above: int) -> bool:
    """True if `process` is `above` or one of its descendants."""
    while process > 1:
        if process == above:
            return True
        process = parent_of(process)
    return False


def parent_of(process: int) -> int:
    """The parent of a process; 0 if the process does not exist."""
    try:
        with open(f"/proc/{process}/stat", "rb") as file:
            return int(file.read().rpartition(b")")[2].split()[1])
    except OSError:
        return 0
