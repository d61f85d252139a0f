"""What it costs as it grows: nodes, lines, clients, FD lengths, error rates; memory for each of them.

    python benchmarks/scale.py [--short] [--plot FILE.svg]

Processor time, not the clock's, so that other work on the machine counts little; the least of several runs. "Per copy"
divides by the receivers. The exponent is that of a power law through the row's points: 1 is linear. Ends with status 1
if anything grows faster than linear (exponent above 1.15). `--plot` draws it (needs canwire[bench]).
"""

from __future__ import annotations

import argparse
import math
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import canwire
from canwire import ChannelMode, Frame, Lab, LineMode

BATCH = 500
FRAME_BITS = 120  # about
STEEPEST = 1.15


class Point(NamedTuple):
    """So many of something, and what a frame (or one more of it) costs then."""

    size: float
    cost: float
    copies: int = 1


class Row(NamedTuple):
    """How a cost grows: `unit` per frame, or per thing for memory; `grows` says whether the exponent is judged."""

    name: str
    of: str
    unit: str
    points: list[Point]
    grows: bool = True

    def exponent(self) -> float:
        """Of the power law with the least squares through the points, first to last."""
        xs = [math.log(point.size) for point in self.points]
        ys = [math.log(point.cost) for point in self.points]
        x, y = sum(xs) / len(xs), sum(ys) / len(ys)
        return sum((a - x) * (b - y) for a, b in zip(xs, ys, strict=True)) / sum((a - x) ** 2 for a in xs)


def frames_of(length: int = 8, *, fd: bool = False) -> object:
    frames = [Frame(0x100 + k % 64, bytes(length), fd=fd, bit_rate_switch=fd) for k in range(BATCH)]
    return canwire.frames_to_array(frames)


def on_a_bus(
    nodes: int,
    count: int,
    *,
    length: int = 8,
    fd: bool = False,
    errors: float = 0.0,
    bitwise: bool = False,
) -> float:
    """Microseconds of processor a frame: one sends, all others receive into their rings, which are emptied."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=1_000_000, data_bit_rate=4_000_000 if fd else None)
        sender = bus.node("n0", receive_queue=1, transmit_queue=BATCH)
        others = [bus.node(f"n{k}", receive_queue=BATCH) for k in range(1, nodes)]
        bus.wire.bitwise = bitwise
        if errors:
            bus.faults.noise(1 - (1 - errors / 100) ** (1 / FRAME_BITS))
        batch = frames_of(length, fd=fd)
        spent = 0.0
        for _ in range(max(1, count // BATCH)):
            sender.send_array(batch)
            began = time.process_time()
            lab.run_until_idle()
            spent += time.process_time() - began
            for other in others:
                other.receive_array()
        return 1e6 * spent / bus.frames


def on_many_buses(buses: int, count: int) -> float:
    """The same with two nodes on each of many buses of one lab."""
    with Lab() as lab:
        made = [lab.can_bus(f"can{k}", bit_rate=1_000_000) for k in range(buses)]
        senders = [bus.node("a", receive_queue=1, transmit_queue=BATCH) for bus in made]
        takers = [bus.node("b", receive_queue=BATCH) for bus in made]
        batch = frames_of()
        spent = 0.0
        for _ in range(max(1, count // (BATCH * buses))):
            for sender in senders:
                sender.send_array(batch)
            began = time.process_time()
            lab.run_until_idle()
            spent += time.process_time() - began
            for taker in takers:
                taker.receive_array()
        return 1e6 * spent / sum(bus.frames for bus in made)


def on_a_hub(clients: int, count: int) -> float:
    """A shared board of a hub in this process: so many channels hear every frame; sending and reading included."""
    with canwire.connect(time="fast", config=canwire.Config.default()) as hub:
        board = hub.boards()[0].id
        for line in (0, 1):
            control = hub.open_control(board, line)
            control.initialise(LineMode(canwire.BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)))
            control.start()
        sender = hub.open_channel(board, 0)
        sender.set_up(ChannelMode(1, 2 * BATCH, frames=False))
        sender.activate()
        takers = [hub.open_channel(board, 1) for _ in range(clients)]
        for taker in takers:
            taker.set_up(ChannelMode(2 * BATCH, 0))
            taker.activate()
        batch, rounds = frames_of(), max(1, count // BATCH)
        began = time.process_time()
        for _ in range(rounds):
            sender.send_array(batch)
            for taker in takers:
                _take_batch(taker)
        return 1e6 * (time.process_time() - began) / (rounds * BATCH)


def _take_batch(channel: canwire.HubChannel) -> None:
    left = BATCH
    while left:
        channel.reading.threshold = left
        taken = len(channel.receive_array(left, 30.0))
        if not taken:
            raise SystemExit(f"{channel}: {left} of {BATCH} frames have not come")
        left -= taken


def resident_kib() -> float:
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * 4.0


def memory_of_nodes(count: int) -> float:
    """KiB a node with queues of 1,024 frames, of one bus."""
    with Lab() as lab:
        bus = lab.can_bus("can0")
        before = resident_kib()
        nodes = [bus.node(f"n{k}", receive_queue=1024, transmit_queue=1024) for k in range(count)]
        return (resident_kib() - before) / len(nodes)


def memory_of_buses(count: int) -> float:
    """KiB a bus with nobody on it."""
    with Lab() as lab:
        before = resident_kib()
        buses = [lab.can_bus(f"can{k}") for k in range(count)]
        return (resident_kib() - before) / len(buses)


def memory_of_channels(count: int) -> float:
    """KiB a channel with queues of 1,024 frames, hub and client side together."""
    with canwire.connect(time="fast", config=canwire.Config.default()) as hub:
        board = hub.boards()[0].id
        before = resident_kib()
        channels = [hub.open_channel(board, 0) for _ in range(count)]
        for channel in channels:
            channel.set_up(ChannelMode(1024, 1024))
        return (resident_kib() - before) / len(channels)


def least(run: Callable[[], float], runs: int) -> float:
    return min(run() for _ in range(runs))


def time_rows(scale: int, runs: int) -> list[Row]:
    few = 20_000 // scale

    def row(name: str, of: str, sizes: list[float], cost: Callable[[float], float], **more: bool) -> Row:
        points = [Point(size, least(lambda s=size: cost(s), runs)) for size in sizes]
        return Row(name, of, "us/frame", points, **more)

    nodes = row("nodes on a bus", "nodes", [2, 4, 16, 64, 256], lambda n: on_a_bus(int(n), few))
    bits = row(
        "bit by bit, nodes", "nodes", [2, 4, 16, 64], lambda n: on_a_bus(int(n), few // 4, bitwise=True)
    )
    clients = row("clients of a board", "channels", [1, 2, 5, 10, 25, 50], lambda n: on_a_hub(int(n), few))
    return [
        _per_copy(nodes, less=1),
        _per_copy(bits, less=1),
        row("buses of a lab", "buses", [1, 5, 20, 50, 200], lambda n: on_many_buses(int(n), 5 * few)),
        _per_copy(clients, less=0),
        row(
            "FD frames' lengths",
            "bytes",
            [8, 16, 32, 64],
            lambda n: on_a_bus(4, few, length=int(n), fd=True),
        ),
        row("frames with errors", "%", [0.1, 1.0, 3.0, 10.0], lambda n: on_a_bus(4, few, errors=n)),
    ]


def _per_copy(row: Row, *, less: int) -> Row:
    return row._replace(points=[point._replace(copies=int(point.size) - less) for point in row.points])


MEMORY: dict[str, Callable[[int], float]] = {
    "memory of a lab's node, 2 x 1,024 frames": memory_of_nodes,
    "memory of a lab's bus": memory_of_buses,
    "memory of a channel, 2 x 1,024 frames": memory_of_channels,
}


def memory_rows(scale: int) -> list[Row]:
    many = [100 // scale, 400 // scale, 1000 // scale]
    return [
        Row(name, "of them", "KiB each", [Point(size, in_fresh_process(name, size)) for size in many], False)
        for name in MEMORY
    ]


def in_fresh_process(name: str, count: int) -> float:
    """Where no memory that others gave back is used again."""
    command = [sys.executable, __file__, "--memory", name, str(count)]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def shown(row: Row) -> list[str]:
    """Lines of the table: what it costs at each size, and how it grows."""
    points = ", ".join(f"{point.size:g}: {_figure(point.cost)}" for point in row.points)
    copies = [point for point in row.points if point.copies > 1]
    per_copy = ", ".join(f"{point.size:g}: {1000 * point.cost / point.copies:.0f}" for point in copies)
    growth = f"{row.exponent():.2f}" if row.grows else ""
    return [f"| {row.name} | {row.unit} by {row.of}: {points} | {per_copy} | {growth} |"]


def _figure(value: float) -> str:
    return f"{value:.3g}" if value < 100 else f"{value:,.0f}"


def draw(rows: list[Row], target: Path) -> None:
    """Every row relative to its first point, on logarithmic axes, beside a line that is linear."""
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(8, 5))
    for row in rows:
        first = row.points[0]
        axes.plot(
            [point.size / first.size for point in row.points],
            [point.cost / first.cost for point in row.points],
            marker="o",
            label=f"{row.name} (from {first.size:g} {row.of}: {_figure(first.cost)} {row.unit})",
        )
    limit = max(point.size / row.points[0].size for row in rows for point in row.points)
    axes.plot([1, limit], [1, limit], linestyle=":", color="gray", label="linear")
    axes.set(xscale="log", yscale="log", xlabel="times as many", ylabel="times the cost of a frame")
    axes.legend(fontsize=8)
    axes.grid(visible=True, which="both", alpha=0.2)
    figure.tight_layout()
    figure.savefig(target)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--memory", nargs=2, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.memory:
        print(MEMORY[asked.memory[0]](int(asked.memory[1])))
        return 0
    timed = time_rows(10 if asked.short else 1, 2 if asked.short else 3)
    print(f"canwire {canwire.__version__}, {canwire.core_mode()} core")
    print("| what grows | cost | ns per copy | exponent |\n|---|---|---|---|")
    for row in [*timed, *memory_rows(10 if asked.short else 1)]:
        print("\n".join(shown(row)))
    if asked.plot:
        draw(timed, asked.plot)
    steep = [row.name for row in timed if row.grows and row.exponent() > STEEPEST]
    if steep:
        print(f"grows faster than linear: {', '.join(steep)}", file=sys.stderr)
    return 1 if steep else 0


if __name__ == "__main__":
    sys.exit(main())
