"""A thread's turn inside one program, in a hub's virtual time; beside it bare locks, and SimPy where it is installed.

    python benchmarks/threads.py [--threads 2 20] [--turns 100000]

Each thread sleeps a millisecond of the hub's time, again and again: a turn is one such sleep. The bare locks hand a
word round among as many threads and do nothing else, which is the least that threads can cost. SimPy has generators
instead, which never wait inside of a call. All of them run in the same run, one after the other; best of `--repeat`.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import threading
import time
from collections.abc import Callable

import canwire


def in_time(threads: int, turns: int) -> float:
    """Seconds for so many turns of all threads together."""

    def sleep() -> None:
        for _ in range(turns // threads):
            time.sleep(0.001)

    clock = time.perf_counter
    with canwire.connect(time="virtual") as hub:
        begin_s = clock()
        with canwire.in_time(hub):
            everybody = [threading.Thread(target=sleep) for _ in range(threads)]
            for one in everybody:
                one.start()
            for one in everybody:
                one.join()
        return clock() - begin_s


def locks(threads: int, turns: int) -> float:
    """The same number of handovers, by one lock each."""
    gates = [threading.Lock() for _ in range(threads)]
    for gate in gates:
        gate.acquire()

    def hand_on(number: int) -> None:
        for _ in range(turns // threads):
            gates[number].acquire()
            gates[(number + 1) % threads].release()

    everybody = [threading.Thread(target=hand_on, args=(number,)) for number in range(threads)]
    for one in everybody:
        one.start()
    begin_s = time.perf_counter()
    gates[0].release()
    for one in everybody:
        one.join()
    return time.perf_counter() - begin_s


def simpy(threads: int, turns: int) -> float:
    """SimPy's processes, which are generators."""
    import simpy as library  # type: ignore[import-not-found, unused-ignore]

    environment = library.Environment()

    def sleep() -> object:
        for _ in range(turns // threads):
            yield environment.timeout(1)

    for _ in range(threads):
        environment.process(sleep())
    begin_s = time.perf_counter()
    environment.run()
    return time.perf_counter() - begin_s


def main() -> None:
    """Print one row for each number of threads."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--threads", type=int, nargs="+", default=[2, 20])
    parser.add_argument("--turns", type=int, default=100_000)
    parser.add_argument("--repeat", type=int, default=3)
    arguments = parser.parse_args()
    ways: list[Callable[[int, int], float]] = [in_time, locks]
    if importlib.util.find_spec("simpy"):
        ways.append(simpy)
    for threads in arguments.threads:
        shown = []
        for way in ways:
            best_s = min(way(threads, arguments.turns) for _ in range(arguments.repeat))
            shown.append(f"{way.__name__} {best_s / arguments.turns * 1e6:6.1f} us")
        print(f"{threads:3} threads: {', '.join(shown)} a turn; load {os.getloadavg()[0]:.1f}", flush=True)


if __name__ == "__main__":
    main()
