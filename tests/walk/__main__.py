"""python -m tests.walk [SECONDS] [--seed N] [--module NAME]: calls every name with what it was not made for.

Each compiled and each public name is tried with None, wrong types, extremes, things never initialised and things that
call back, on a thing that was never initialised and on one in the middle of its work; then, for SECONDS in all
(default: 60), with anything at random. What ends or hangs the interpreter, or is a SystemError, is a row; status 1 if
there is any.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time

import canwire
from tests.walk.attempts import Subjects
from tests.walk.child import Walked, walked
from tests.walk.names import modules
from tests.walk.scene import found_in, scene


def walk(name: str, seed: int, seconds: float, folder: str) -> Walked:
    """One module: everything once, then anything for so long."""
    os.environ["XDG_RUNTIME_DIR"] = folder
    things = scene()
    healthy = found_in(things)
    result = walked(lambda: Subjects(name, healthy, seed).systematic(), folder)
    if seconds:
        until = time.monotonic() + seconds
        more = walked(lambda: Subjects(name, healthy, seed).at_random(), folder, until)
        result.count += more.count
        result.wrong += more.wrong
    return result


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.walk", description=__doc__)
    parser.add_argument("seconds", nargs="?", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--module", action="append", help="only this one; may be given several times")
    arguments = parser.parse_args()
    names = arguments.module or modules()
    count, wrong = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            done = walk(name, arguments.seed, arguments.seconds / len(names), folder)
            count, wrong = count + done.count, wrong + len(done.wrong)
            print(f"{name}: {done.count:,} attempts, {len(done.wrong)} wrong", flush=True)
            for row in done.wrong:
                print(f"    {row}", flush=True)
    print(f"{count:,} attempts, {wrong} wrong, {canwire.core_mode()} core")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
