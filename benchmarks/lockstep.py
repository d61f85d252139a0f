"""One time for many programs: steps a second, beside bare pipes that hand a word round in the same way.

    python benchmarks/lockstep.py [--seconds 3] [--programs 2 20]

A step is 1 ms of the hub's time, in which every program has one turn: each sleeps so long, again and again. The bare
pipes do as many handovers and nothing else: one process writes a byte to each of the others in turn, and waits for its
answer. Both run in the same run, one after the other; best of `--repeat`.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import canwire

_PROGRAM = """
import sys, canwire

def connected():
    for _ in range(20):  # where many start at once, the hub may not answer within its two seconds
        try:
            return canwire.connect(timed=True)
        except canwire.HubLost:
            pass
    raise SystemExit("the hub does not answer")

with connected() as hub:
    for _ in range(int(sys.argv[1])):
        hub.sleep(0.001)
"""


def lockstep(programs: int, steps: int) -> float:
    """Steps a second, from the first turn to the last program's end; a hub in a process of its own."""
    with tempfile.TemporaryDirectory() as home:
        address = str(Path(home) / "hub.sock")
        serve = [sys.executable, "-m", "canwire", "serve", "--time", "lockstep", "--socket", address]
        hub = subprocess.Popen([*serve, "--programs", str(programs + 1)], stdout=subprocess.PIPE, text=True,
                               stderr=subprocess.DEVNULL)  # fmt: skip
        assert hub.stdout is not None
        hub.stdout.readline()
        others: list[subprocess.Popen[bytes]] = []
        try:
            others += [
                subprocess.Popen(
                    [sys.executable, "-c", _PROGRAM, str(steps)],
                    env={**os.environ, "CANWIRE_HUB": address, "CANWIRE_NAME": f"program {number}"},
                )
                for number in range(programs)
            ]
            with canwire.connect(address, timed=True, name="a clock") as clock:
                begin_s = time.perf_counter()
                clock.sleep(steps / 1000)
                taken_s = time.perf_counter() - begin_s
            for one in others:
                assert one.wait(60) == 0
        finally:
            for one in others:
                one.kill()
            hub.terminate()
            hub.wait(30)
            hub.stdout.close()
    return steps / taken_s


def pipes(programs: int, steps: int) -> float:
    """Rounds a second of a byte that goes to each process and back, by pipes alone."""
    there, back = [os.pipe() for _ in range(programs)], [os.pipe() for _ in range(programs)]
    children = []
    for number in range(programs):
        child = os.fork()
        if child == 0:
            for _ in range(steps):
                os.read(there[number][0], 1)
                os.write(back[number][1], b".")
            os._exit(0)
        children.append(child)
    begin_s = time.perf_counter()
    for _ in range(steps):
        for number in range(programs):
            os.write(there[number][1], b".")
            os.read(back[number][0], 1)
    taken_s = time.perf_counter() - begin_s
    for child in children:
        os.waitpid(child, 0)
    for reading, writing in there + back:
        os.close(reading)
        os.close(writing)
    return steps / taken_s


def main() -> None:
    """Print one row for each number of programs."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--programs", type=int, nargs="+", default=[2, 20])
    parser.add_argument("--steps", type=int, default=20_000, help="turns of all programs together, each time")
    parser.add_argument("--repeat", type=int, default=3)
    arguments = parser.parse_args()
    assert threading.active_count() == 1, "pipes() forks"
    for programs in arguments.programs:
        steps = max(1, arguments.steps // programs)
        bare = max(pipes(programs, steps) for _ in range(arguments.repeat))
        ours = max(lockstep(programs, steps) for _ in range(arguments.repeat))
        print(
            f"{programs:3} processes: {ours:8,.0f} steps/s ({ours * programs:8,.0f} turns/s); "
            f"bare pipes {bare:8,.0f} ({bare * programs:8,.0f}); load {os.getloadavg()[0]:.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
