"""What an MCP2515 line costs on a saturated 1 Mbit/s bus: share of one core, by what it does and how long frames are.

    python benchmarks/mcp2515.py [--seconds 1.0]

The line's bare cost beside it: the same with the ideal controller. Fails where the MCP2515 needs 60 % of a core.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

from canwire import BitTiming, Frame
from canwire.boards.can.channel import Channel
from canwire.boards.can.line import Line
from canwire.boards.catalogue import ideal_line, mcp2515_line, plug
from canwire.bus.can.bus import CanBus
from canwire.drivers.driver import LineSettings
from canwire.timeline import Timeline

TIMING = BitTiming.for_bit_rate(1_000_000, clock_hz=8_000_000)
SLICE_NS = 10_000_000
QUEUE = 512
CHANNELS = 3
LIMIT = 0.60


def started(line: Line, bus: CanBus) -> tuple[Line, list[Channel]]:
    plug(line, bus)
    line.driver.configure(LineSettings(TIMING))
    line.driver.start(0)
    return line, [line.open(Channel(4 * QUEUE, QUEUE)) for k in range(CHANNELS)]


def cost(
    maker: Callable[[str, Timeline], Line], senders: str, data: bytes, seconds: float
) -> tuple[float, float, int]:
    """Share of a core, frames/s on the bus, frames lost; `senders` names who sends: "line", "partner" or both."""
    timeline = Timeline()
    bus = CanBus(timeline)
    line, channels = started(maker("line", timeline), bus)
    partner, others = started(ideal_line("partner", timeline), bus)
    timeline.run_until(1_000_000)
    everybody = [*channels, *others]
    sending = [(line, channels, 0x100), (partner, others, 0x200)]
    chosen = [one for one in sending if one[0].name in senders.split("+")]
    spent = 0.0
    while timeline.now_ns < seconds * 1e9:
        for who, its, id in chosen:
            for k, channel in enumerate(its):
                while channel.transmit.free():
                    who.send(channel, Frame(id + k, data))
        began = time.process_time()
        timeline.run_until(timeline.now_ns + SLICE_NS)
        spent += time.process_time() - began
        for channel in everybody:
            channel.receive.take_frames(4 * QUEUE)
    elapsed = timeline.now_ns / 1e9
    done = sum(channel.delivered for channel in everybody)
    lost = done - line.driver.counters().frames_received - partner.driver.counters().frames_received
    return spent / elapsed, done / elapsed, lost


def rows(seconds: float) -> list[tuple[str, str, str, str]]:
    """For the table of run.py."""
    share, rate, lost = cost(mcp2515_line, "line+partner", bytes(8), seconds)
    return [
        (
            "MCP2515 line, 1 Mbit/s saturated by three senders",
            f"{100 * share:.0f} % of a core, {rate:,.0f} frames/s, {lost} lost",
            "",
            "< 60 %, 0 lost",
        )
    ]


def main() -> int:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--seconds", type=float, default=1.0)
    seconds = arguments.parse_args().seconds
    worst = 0.0
    print(f"{'senders':>14} {'bytes':>5} {'frames/s':>9} {'core':>7} {'ideal':>7} {'lost':>5}")
    for senders in ("line", "partner", "line+partner"):
        for data in (b"", bytes(8)):
            ideal = cost(ideal_line, senders, data, seconds)[0]
            share, rate, lost = cost(mcp2515_line, senders, data, seconds)
            worst = max(worst, share)
            print(f"{senders:>14} {len(data):>5} {rate:>9.0f} {share:>7.1%} {ideal:>7.1%} {lost:>5}")
    return worst >= LIMIT


if __name__ == "__main__":
    raise SystemExit(main())
