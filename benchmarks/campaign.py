"""A campaign on processes, beside the same runs in one process: what handing out costs. Then what crashes cost.

python benchmarks/campaign.py [--runs 200] [--short 10000] [--workers 2]
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from pathlib import Path

import canwire
from canwire.campaigns.loading import Script
from canwire.campaigns.playing import Order, play

TEXT = """
import canwire

@canwire.campaign(place=range(1000))
def loaded(lab, place):
    bus = lab.can_bus("can0")
    a, b = bus.node("a"), bus.node("b")
    for number in range({frames}):
        a.send(canwire.Frame(0x100 + number % 64, bytes(8)))
    lab.run_until_idle()
    assert b.receive_many({frames} + 1)
"""
ABORTS = """
import os
import canwire

@canwire.campaign(place=range(100))
def aborts(lab, place):
    bus = lab.can_bus("can0")
    a, b = bus.node("a"), bus.node("b")
    for number in range(50):
        a.send(canwire.Frame(0x100 + number, bytes(8)))
    lab.run_until_idle()
    if place == {place}:
        os.abort()
"""
WANTED_S = 0.034  # a run of the goal's


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=200, help="of the first part; 0: without it")
    parser.add_argument(
        "--short", type=int, default=10_000, help="runs of 50 frames, with and without 1 %% that crash"
    )
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    if arguments.runs:
        handing_out(arguments.runs, arguments.workers)
    costs = [with_crashes(place, arguments.short, arguments.workers) for place in (-1, 50, 50, -1)]  # A B B A
    for what, *found in zip(("seconds", "of processors"), *costs, strict=True):
        a, b = found[0] + found[3], found[1] + found[2]
        print(f"{arguments.short} short runs, twice    {a:8.2f} s {what}")
        print(f"with 1 % that crash        {b:8.2f} s {what} = {b / a:.2f} of that (goal: 1.5)")


def handing_out(runs: int, workers: int) -> None:
    """What a campaign costs beside its runs."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "loaded.py"
        frames = 1000
        path.write_text(TEXT.format(frames=frames))
        frames = max(10, min(12_000, int(frames * WANTED_S / one_run(path, 20))))
        path.write_text(TEXT.format(frames=frames))
        before_s = one_run(path, 40)
        began = time.perf_counter()
        played = canwire.run_campaign(path, runs=runs, workers=workers)
        took_s = time.perf_counter() - began
        run_s = (before_s + one_run(path, 40)) / 2
    assert all(run.passed for run in played), played[0].reason
    ideal_s = runs * run_s / workers
    print(f"one run, in this process   {run_s * 1e3:8.1f} ms ({frames} frames)")
    print(f"ideal, {runs} runs on {workers}    {ideal_s:8.2f} s")
    print(f"campaign                   {took_s:8.2f} s = {took_s / ideal_s:.2f} of the ideal")


def with_crashes(place: int, runs: int, workers: int) -> tuple[float, float]:
    """What a campaign takes in which the run at `place` of each hundred ends its process (-1: none).

    Seconds by the clock, and of processors.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "aborts.py"
        path.write_text(ABORTS.format(place=place))
        began, used = time.perf_counter(), processor_s()
        played = canwire.run_campaign(path, runs=runs, workers=workers)
        took = time.perf_counter() - began, processor_s() - used
    expected = sum(number % 100 == place for number in range(runs))
    assert [run.verdict for run in played].count("crashed") == expected
    return took


def processor_s() -> float:
    """Of this process and those that it has waited for."""
    each = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in each)


def one_run(path: Path, runs: int) -> float:
    """Seconds a run takes here."""
    campaign = Script.read(path).load()
    began = time.perf_counter()
    for number in range(runs):
        play(campaign, Order(number), 1)
    return (time.perf_counter() - began) / runs


if __name__ == "__main__":
    main()
