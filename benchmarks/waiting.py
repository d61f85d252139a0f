"""What waiting costs: one frame's way, a hub in real time, and how often its thread is woken up.

    python benchmarks/waiting.py [SECONDS]     of each measurement (3)

Beside it, in the same run: python-can's udp_multicast, and a relay of three bare processes that hand a stamp on
through pipes, which is what Python and the scheduler of this machine take without any bus.
"""

from __future__ import annotations

import os
import select
import sys
import time
from pathlib import Path
from typing import Any

import lin
import shared

import canwire


def woken(served: shared.Served) -> int:
    """How often threads of the hub have waited so far."""
    count = 0
    for status in Path(f"/proc/{served.process.pid}/task").glob("*/status"):
        lines = status.read_text().splitlines()
        count += sum(int(line.split()[1]) for line in lines if line.startswith("voluntary_ctxt"))
    return count


def one_way(mode: str, seconds: float) -> str:
    """Frames of one process to another at 1,000 a second; `fast`: the bus takes no time, `real`: 111 us of 1 Mbit/s."""
    count = round(1000 * seconds)
    ready, results = shared.CONTEXT.Semaphore(0), shared.CONTEXT.Queue()
    with shared.served(mode) as process, shared.running(process.address) as (hub, board):
        receiver = shared.CONTEXT.Process(target=shared.listen, args=(process.address, ready, results, count))
        receiver.start()
        ready.acquire()
        channel = shared.sender(hub, board)
        used, waited = process.processor_s(), woken(process)
        for stamp in shared.paced(count):
            channel.send(canwire.Frame(0x100, stamp.to_bytes(8, "little")))
        used, waited = process.processor_s() - used, woken(process) - waited
        ways = shared.percentiles(results.get())
        receiver.join()
    return f"{told(ways)}, hub {1e6 * used / count:.0f} us and {waited / count:.1f} wake-ups a frame"


def saturated(seconds: float, clients: int) -> str:
    share, speed, lost = shared.real_time(seconds, clients)
    return f"hub {share:.1f} % of a core, {speed:,.0f} frames/s, {lost} lost"


def idle(seconds: float) -> str:
    with shared.served("real") as process, shared.running(process.address):
        used, waited = process.processor_s(), woken(process)
        time.sleep(seconds)
        share = 100 * (process.processor_s() - used) / seconds
        return f"{share:.2f} % of a core, {(woken(process) - waited) / seconds:.0f} wake-ups/s"


def hand_on(source: int, target: int, count: int, results: Any) -> None:
    """One process of the relay; without a target the last, which tells how long each stamp was on its way."""
    ways = []
    for _ in range(count):
        select.select([source], (), (), shared.PATIENCE_S)
        stamp = os.read(source, 8)
        if target >= 0:
            os.write(target, stamp)
        else:
            ways.append(time.perf_counter_ns() - int.from_bytes(stamp, "little"))
    if ways:
        results.put(ways)


def relay(seconds: float) -> str:
    """A stamp through two pipes, by way of a process between."""
    import multiprocessing

    context = multiprocessing.get_context("fork")  # pipes are handed down
    count, results = round(1000 * seconds), context.Queue()
    (first, begin), (second, middle) = os.pipe(), os.pipe()
    processes = [
        context.Process(target=hand_on, args=(first, middle, count, results)),
        context.Process(target=hand_on, args=(second, -1, count, results)),
    ]
    for process in processes:
        process.start()
    for stamp in shared.paced(count):
        os.write(begin, stamp.to_bytes(8, "little"))
    ways = results.get()
    for process in processes:
        process.join()
    for descriptor in (first, begin, second, middle):
        os.close(descriptor)
    return told(shared.percentiles(ways))


def told(ways: tuple[float, float]) -> str:
    return f"p50 {ways[0]:.0f} us, p99 {ways[1]:.0f} us"


def main(seconds: float) -> None:
    count = round(1000 * seconds)
    for what, measure in (
        ("bare pipes, three processes", lambda: relay(seconds)),
        ("python-can udp_multicast", lambda: told(shared.multicast(count, paced_sending=True)[2])),
        ("canwire, fast time", lambda: one_way("fast", seconds)),
        ("canwire, real time", lambda: one_way("real", seconds)),
        ("1 Mbit/s saturated, nobody waits", lambda: saturated(seconds, 0)),
        ("1 Mbit/s saturated, 4 clients wait", lambda: saturated(seconds, 4)),
        ("LIN schedule, nobody listens", lambda: f"hub {lin.real(seconds):.2f} % of a core"),
        ("LIN schedule, a program waits", lambda: f"hub {lin.real(seconds, heard=True):.2f} % of a core"),
        ("two lines started, nothing happens", lambda: idle(seconds)),
    ):
        print(f"{what:36} {measure()}", flush=True)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 3.0)
