"""Random schedules for as long as one likes: the bus against the reference, and what it came to.

    python -m tests.bus.can.reference.long_run --frames 1000000 --faults 10000 --processes 2 [--first SEED]

Each seed is one schedule; a run that was interrupted goes on with `--first` and the seed printed last. `--rounds`
runs the whole thing for so many seeds instead. With `--glitches` levels are held for parts of bits, not for whole ones.
Ends with status 1 if anything differed, and prints which seeds did.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import count, islice

from tests.bus.can.reference.compare import differences
from tests.bus.can.reference.players import Outcome, by_the_rules
from tests.bus.can.reference.schedule import Schedule, schedule_of

FRAMES_A_SCHEDULE = 30  # about: several nodes may send at once
DISTURBED_EVERY = 4  # one schedule of so many
AT_ONCE = 20  # schedules a process is given at a time


def main() -> int:
    arguments = parsed()
    began = time.monotonic()
    total: Counter[str] = Counter()
    wrong: list[tuple[int, list[str]]] = []
    with ProcessPoolExecutor(arguments.processes) as pool:
        for last, figures, found in batches(pool, arguments):
            total += figures
            wrong += found
            for seed, words in found:
                print(f"\nseed {seed}: {words[0]}")
            print(f"\r{report(total, last, time.monotonic() - began)}", end="", flush=True)
            if done(arguments, total, last):
                break
        pool.shutdown(cancel_futures=True)
    print(f"\n{len(wrong)} schedules differ" + "".join(f"\n  seed {seed}: {words}" for seed, words in wrong))
    return 1 if wrong else 0


def parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=10_000, help="go on until so many were received well")
    parser.add_argument("--faults", type=int, default=100, help="and so many disturbances were set up")
    parser.add_argument("--rounds", type=int, help="instead: so many schedules")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="the first schedule")
    parser.add_argument("--faulty", type=int, default=8, help="at most so many disturbances a schedule")
    parser.add_argument(
        "--glitches", type=int, default=0, help="at most so many a schedule that is disturbed"
    )
    parser.add_argument("--processes", type=int, default=1)
    return parser.parse_args()


def done(arguments: argparse.Namespace, total: Counter[str], last: int) -> bool:
    if arguments.rounds is not None:
        return bool(last - arguments.first + 1 >= arguments.rounds)
    return bool(total["frames"] >= arguments.frames and total["faults"] >= arguments.faults)


Batch = tuple[int, Counter[str], list[tuple[int, list[str]]]]


def batches(pool: ProcessPoolExecutor, arguments: argparse.Namespace) -> Iterator[Batch]:
    """What came of the seeds from the first on, in their order; two batches a process are under way."""
    starts = count(arguments.first, AT_ONCE)
    disturbances = arguments.faulty, arguments.glitches
    waiting = [pool.submit(play, start, *disturbances) for start in islice(starts, 2 * arguments.processes)]
    while True:
        done_first = waiting.pop(0)
        waiting.append(pool.submit(play, next(starts), *disturbances))
        yield done_first.result()


def play(first: int, faulty: int, glitches: int) -> Batch:
    """So many schedules from this seed on: the last seed, figures, and what differed."""
    figures: Counter[str] = Counter()
    found = []
    for seed in range(first, first + AT_ONCE):
        schedule = scheduled(seed, faulty, glitches)
        rules = by_the_rules(schedule)
        if words := differences(schedule, rules):
            found.append((seed, words))
        figures["schedules"] += 1
        disturbances = sum(times for _, times, _ in schedule.flips) + len(schedule.holds)
        figures["faults"] += (
            disturbances + len(schedule.shorts) + len(schedule.stops) + len(schedule.glitches)
        )
        figures += figures_of(rules)
    return first + AT_ONCE - 1, figures, found


def scheduled(seed: int, faulty: int, glitches: int) -> Schedule:
    if seed % DISTURBED_EVERY:
        faulty = glitches = 0
    return schedule_of(seed, frames=FRAMES_A_SCHEDULE, faults=faulty, roles=True, glitches=glitches)


def figures_of(outcome: Outcome) -> Counter[str]:
    told = Counter(event[0] for events in outcome.events for event in events)
    return Counter(
        frames=sum(outcome.delivered),
        receptions=sum(len(received) for received in outcome.received),
        errors=told["error"],
        states=told["state"],
        losses=told["lost"],
        edges=len(outcome.levels or ()),
    )


def report(total: Counter[str], last: int, took_s: float) -> str:
    figures = ", ".join(
        f"{total[name]:,} {name}" for name in ("frames", "faults", "errors", "states", "losses")
    )
    return (
        f"seed {last}: {total['schedules']:,} schedules, {figures}; {total['frames'] / took_s:.0f} frames/s"
    )


if __name__ == "__main__":
    sys.exit(main())
