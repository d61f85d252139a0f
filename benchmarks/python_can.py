"""python-can on shared boards, processes apart, beside python-can's `virtual` in one process; and who sends on time.

Both do what python-can programs do: `send` and `recv` of single messages.
"""

from __future__ import annotations

import itertools
import statistics
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.synchronize import Event, Semaphore
from typing import Any

import can
import shared
import workloads

from canwire.python_can import CanwireBus

PERIOD_S = 0.001
PATIENCE_S = 10.0


def receive(address: str, ready: Semaphore, results: Any, count: int) -> None:
    """A receiving process: how many of so many messages came."""
    with CanwireBus("HW000001:1", hub=address, rx_fifo_size=shared.QUEUE) as bus:
        ready.release()
        got = 0
        recv = bus.recv
        while got < count and recv(PATIENCE_S) is not None:
            got += 1
        results.put(got)


def throughput(count: int, receivers: int) -> float:
    """Messages/s sent, each received by everybody; sender, hub and receivers in processes of their own."""
    ready, results = shared.CONTEXT.Semaphore(0), shared.CONTEXT.Queue()
    with shared.served("fast") as hub, CanwireBus("HW000001:0", hub=hub.address, bitrate=1_000_000) as bus:
        arguments = (hub.address, ready, results, count)
        processes = [shared.CONTEXT.Process(target=receive, args=arguments) for _ in range(receivers)]
        for process in processes:
            process.start()
        for _ in processes:
            ready.acquire()
        began = time.perf_counter()
        for k in range(count):
            bus.send(can.Message(arbitration_id=k & 0x7FF, data=b"\x11\x22\x33\x44", is_extended_id=False))
        outcomes = [results.get() for _ in processes]
        spent = time.perf_counter() - began
        for process in processes:
            process.join()
    assert outcomes == [count] * receivers, outcomes
    return count / spent


def send_busily(address: str, began: Event, ended: Event, threaded: bool) -> None:
    """A program with a periodic message, whose Python thread computes all the time."""
    message = can.Message(arbitration_id=0x100, data=bytes(8), is_extended_id=False)
    with CanwireBus("HW000001:0", hub=address, bitrate=1_000_000) as bus:
        changed = (lambda message: None) if threaded else None  # a callback keeps it from the hub
        bus.send_periodic(message, PERIOD_S, modifier_callback=changed)
        began.set()
        while not ended.is_set():
            sum(range(20_000))


@contextmanager
def busy_sender(address: str, threaded: bool) -> Iterator[None]:
    began, ended = shared.CONTEXT.Event(), shared.CONTEXT.Event()
    process = shared.CONTEXT.Process(target=send_busily, args=(address, began, ended, threaded))
    process.start()
    began.wait(PATIENCE_S)
    yield
    ended.set()
    process.join()


def period_errors(seconds: float, *, threaded: bool) -> tuple[list[float], list[float]]:
    """How far the times between two messages are off, in us: on the bus, and as another program received them."""
    count = round(seconds / PERIOD_S)
    with (
        shared.served("real") as hub,
        CanwireBus("HW000001:1", hub=hub.address, bitrate=1_000_000) as bus,
        busy_sender(hub.address, threaded),
    ):
        stamps, arrivals = [], []
        for _ in range(count):
            message = bus.recv(PATIENCE_S)
            assert message is not None
            arrivals.append(time.perf_counter())
            stamps.append(message.timestamp)
    on_bus, received = (
        [abs(after - before - PERIOD_S) * 1e6 for before, after in itertools.pairwise(times[100:])]
        for times in (stamps, arrivals)
    )
    return on_bus, received


def _told(errors: list[float]) -> str:
    p99 = statistics.quantiles(errors, n=100)[98]
    return f"{statistics.fmean(errors):,.0f} / {p99:,.0f} / {max(errors):,.0f} us"


def rows(scale: int, seconds: float) -> list[tuple[str, str, str, str]]:
    """For the table of run.py."""
    table = []
    for receivers, goal in ((1, "1.3 x"), (8, "5 x")):
        ours = throughput(400_000 // scale, receivers)
        theirs = workloads.python_can(50_000 // scale // receivers, receivers)
        what = f"python-can messages, {receivers} receiver(s), processes apart"
        row = (
            f"{ours:,.0f} messages/s = {ours / theirs:.1f} x",
            f"{theirs:,.0f} messages/s, in one process",
            goal,
        )
        table.append((what, *row))
    ours_us, theirs_us = (period_errors(seconds, threaded=threaded) for threaded in (False, True))
    for where, hub_sent, thread_sent, goal in (
        ("on the bus", ours_us[0], theirs_us[0], "p99 1/10"),
        ("as received", ours_us[1], theirs_us[1], ""),
    ):
        what = f"send_periodic at 1 ms, busy program, {where} (mean / p99 / max error)"
        table.append((what, _told(hub_sent), f"its thread {_told(thread_sent)}", goal))
    return table


if __name__ == "__main__":
    for row in rows(4, 5.0):
        print(*row, sep="   ")
