"""Replay a car's log and count what is in it: python examples/replay.py [LOG]"""

from __future__ import annotations

import sys
from collections import defaultdict
from itertools import pairwise
from pathlib import Path
from statistics import median

from canwire import Lab, parse_log_line

CAR = Path(__file__).parent / "car-candump.log"


def main(path: Path = CAR) -> dict[int, tuple[int, float]]:
    """How often each identifier was received, and its usual period in ms."""
    lines = map(parse_log_line, path.read_text().splitlines())
    frames = [line.frame for line in lines if line.frame is not None]
    arrivals: dict[int, list[int]] = defaultdict(list)
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        player, recorder = bus.node("player", transmit_queue=8192), bus.node("recorder", receive_queue=8192)
        for frame in frames:
            lab.run_until(max(lab.now_ns, frame.timestamp_ns - frames[0].timestamp_ns))
            player.send(frame)
            for heard in recorder.receive_many(8192):
                arrivals[heard.id].append(heard.timestamp_ns)
        lab.run_until_idle()
        for heard in recorder.receive_many(8192):
            arrivals[heard.id].append(heard.timestamp_ns)
        print(
            f"{len(frames)} frames in {lab.now_ns / 1e9:.1f} s of bus time, mean load {bus.mean_load:.1f} %"
        )
    found = {}
    for id, stamps in sorted(arrivals.items(), key=lambda item: -len(item[1])):
        gaps = [late - early for early, late in pairwise(stamps)]
        found[id] = (len(stamps), median(gaps) / 1e6 if gaps else 0.0)
    for id, (count, period_ms) in list(found.items())[:5]:
        print(f"  {id:03X}  {count:5} times, every {period_ms:.1f} ms")
    return found


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
