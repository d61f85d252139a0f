"""How late is a frame if any one of its bits is disturbed? canwire campaign examples/campaign.py"""

from __future__ import annotations

import random

import canwire
from canwire import Draw, Frame, Lab

BUDGET_MS = 0.6  # what the receiver of this message can stand


@canwire.campaign(bit=range(110), seen_by=["sender", "receivers"], others=Draw.integer(0, 1))
def disturbed(lab: Lab, bit: int, seen_by: str, others: int) -> dict[str, float]:
    """The frame's delay in ms, with up to one frame of somebody else waiting for the bus too."""
    bus = lab.can_bus("can0", bit_rate=500_000)
    sender, receiver, other = bus.node("sender"), bus.node("receiver"), bus.node("other")
    bus.faults.flip(bit=bit, frame_id=0x123, seen_by=seen_by)
    dice = random.Random(lab.seed)
    began_ns = lab.now_ns
    sender.send(Frame(0x123, dice.randbytes(8)))
    for _ in range(others):
        other.send(Frame(dice.randrange(0x124, 0x7FF), dice.randbytes(8)))
    late_ms = (receiver.expect(0x123, within=0.1).timestamp_ns - began_ns) / 1e6
    assert late_ms <= BUDGET_MS, f"{late_ms:.3f} ms"
    return {"late_ms": late_ms}


if __name__ == "__main__":
    runs = canwire.run_campaign(disturbed)
    latest = max(runs, key=lambda run: run.figures.get("late_ms", 0.0))
    print(f"{len(runs)} runs, {sum(run.passed for run in runs)} in time")
    print(f"the latest, run {latest.number}: {latest.parameters}, {latest.figures}")
