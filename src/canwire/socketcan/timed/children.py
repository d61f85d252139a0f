"""Processes that others have started, as /proc shows them (proc_pid_stat(5))."""

from __future__ import annotations

import os


def children_of(process: int) -> list[int]:
    """Those that it has started itself, ended ones that it has not waited for included."""
    return [
        number
        for number in map(int, filter(str.isdigit, os.listdir("/proc")))
        if parent_of(number) == process
    ]


def is_below(process: int, above: int) -> bool:
    """`process` is `above`, or was started by it, or by one that is below it."""
    while process > 1:
        if process == above:
            return True
        process = parent_of(process)
    return False


def parent_of(process: int) -> int:
    """0 for one that is not there."""
    try:
        with open(f"/proc/{process}/stat", "rb") as file:
            return int(file.read().rpartition(b")")[2].split()[1])
    except OSError:
        return 0
