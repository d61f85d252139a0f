"""A campaign on processes, beside the same runs in one process: what handing out costs. Then what crashes cost.

python benchmarks/campaign.py [--runs 200] [--short 10000] [--workers 2]
"""

from __future__ import annotations

import argparse
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
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--short", type=int, default=10_000, help="runs of 50 frames, 1 %% of them crash")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "loaded.py"
        frames = 1000
        path.write_text(TEXT.format(frames=frames))
        frames = max(10, min(12_000, int(frames * WANTED_S / one_run(path, 20))))
        path.write_text(TEXT.format(frames=frames))
        before_s = one_run(path, 40)
        began = time.perf_counter()
        runs = canwire.run_campaign(path, runs=arguments.runs, workers=arguments.workers)
        took_s = time.perf_counter() - began
        run_s = (before_s + one_run(path, 40)) / 2
    assert all(run.passed for run in runs), runs[0].reason
    ideal_s = arguments.runs * run_s / arguments.workers
    print(f"one run, in this process   {run_s * 1e3:8.1f} ms ({frames} frames)")
    print(f"ideal, {arguments.runs} runs on {arguments.workers}    {ideal_s:8.2f} s")
    print(f"campaign                   {took_s:8.2f} s = {took_s / ideal_s:.2f} of the ideal")
    well_s, crashing_s = (with_crashes(place, arguments.short, arguments.workers) for place in (-1, 50))
    print(f"{arguments.short} short runs          {well_s:8.2f} s")
    print(f"with 1 % that crash        {crashing_s:8.2f} s = {crashing_s / well_s:.2f} of that (goal: 1.5)")


def with_crashes(place: int, runs: int, workers: int) -> float:
    """Seconds of a campaign in which the run at `place` of each hundred ends its process (-1: none)."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "aborts.py"
        path.write_text(ABORTS.format(place=place))
        began = time.perf_counter()
        played = canwire.run_campaign(path, runs=runs, workers=workers)
        took_s = time.perf_counter() - began
    expected = sum(number % 100 == place for number in range(runs))
    assert [run.verdict for run in played].count("crashed") == expected
    return took_s


def one_run(path: Path, runs: int) -> float:
    """Seconds a run takes here."""
    campaign = Script.read(path).load()
    began = time.perf_counter()
    for number in range(runs):
        play(campaign, Order(number), 1)
    return (time.perf_counter() - began) / runs


if __name__ == "__main__":
    main()
