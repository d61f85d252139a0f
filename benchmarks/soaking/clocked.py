"""`canwire` with a clock of the wall that SIGUSR1 sets a day forward, and then back: `python clocked.py serve ...`."""

from __future__ import annotations

import runpy
import signal
import sys
import time
from itertools import cycle

_DAY_NS = 86_400 * 10**9
_offset_ns = 0
_jumps = cycle([_DAY_NS, -_DAY_NS])


def _jump(_signal: int, _frame: object) -> None:
    global _offset_ns
    _offset_ns += next(_jumps)


def main() -> None:
    ours_ns = time.time_ns
    time.time_ns = lambda: ours_ns() + _offset_ns
    time.time = lambda: time.time_ns() / 1e9
    signal.signal(signal.SIGUSR1, _jump)
    sys.argv[0] = "canwire"
    runpy.run_module("canwire", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
