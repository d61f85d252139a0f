"""A campaign on processes, beside the same runs in one process: what handing out costs.

python benchmarks/campaign.py [--runs 200] [--workers 2]
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import canwire
from canwire.campaigns.loading import Script
from canwire.campaigns.playing import play

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
WANTED_S = 0.034  # a run of the goal's


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=200)
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


def one_run(path: Path, runs: int) -> float:
    """Seconds a run takes here."""
    campaign = Script.read(path).load()
    began = time.perf_counter()
    for number in range(runs):
        play(campaign, number, 1)
    return (time.perf_counter() - began) / runs


if __name__ == "__main__":
    main()
