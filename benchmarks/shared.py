"""Boards shared by processes: throughput, latency, cost of real time and of many channels.

The same across two processes with python-can's udp_multicast stands beside it.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from multiprocessing.synchronize import Semaphore
from pathlib import Path
from typing import Any, NamedTuple

import canwire

CONTEXT = multiprocessing.get_context("spawn")
BATCH = 4096
QUEUE = 1 << 16
PATIENCE_S = 10.0
MULTICAST = "239.74.163.2"


class Served(NamedTuple):
    """A hub in a process of its own: where it listens, and its process."""

    address: str
    process: subprocess.Popen[bytes]

    def processor_s(self) -> float:
        """Processor time it has used; the scheduler's own count, not samples of it."""
        tasks = Path(f"/proc/{self.process.pid}/task").glob("*/schedstat")
        return sum(int(task.read_text().split()[0]) for task in tasks) / 1e9

    def resident_bytes(self) -> int:
        pages = Path(f"/proc/{self.process.pid}/statm").read_text().split()[1]
        return int(pages) * os.sysconf("SC_PAGE_SIZE")


@contextlib.contextmanager
def served(mode: str) -> Iterator[Served]:
    """`canwire serve` with the default world."""
    with tempfile.TemporaryDirectory() as folder:
        address = f"{folder}/hub.sock"
        command = [sys.executable, "-m", "canwire", "serve", "--socket", address, "--time", mode]
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
            assert process.stdout is not None
            process.stdout.readline()
            try:
                yield Served(address, process)
            finally:
                process.terminate()


@contextlib.contextmanager
def running(address: str) -> Iterator[tuple[canwire.Hub, int]]:
    """Lines 0 and 1 of the first board started at 1 Mbit/s; the hub and the board."""
    timing = canwire.BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)
    with canwire.connect(address) as hub:
        board = hub.boards()[0].id
        for line in (0, 1):
            control = hub.open_control(board, line)
            control.initialise(canwire.LineMode(timing))
            control.start()
        yield hub, board


def sender(hub: canwire.Hub, board: int) -> canwire.HubChannel:
    channel = hub.open_channel(board, 0)
    channel.set_up(canwire.ChannelMode(1, QUEUE, frames=False))
    channel.activate()
    return channel


def pour(channel: canwire.HubChannel, count: int) -> None:
    """Send so many 8-byte frames as quickly as there is room."""
    frames = canwire.frames_to_array([canwire.Frame(0x100 + k % 64, bytes(8)) for k in range(BATCH)])
    channel.writing.threshold = BATCH
    while count:
        sent = channel.send_array(frames[: min(BATCH, count)])
        count -= sent
        if sent < BATCH and count:
            channel.writing.wait(PATIENCE_S)


def receive(address: str, ready: Semaphore, results: Any, count: int, objects: bool) -> None:
    """A receiving process: tells how many came and how many were lost."""
    with canwire.connect(address) as hub:
        channel = hub.open_channel(hub.boards()[0].id, 1)
        channel.set_up(canwire.ChannelMode(QUEUE, 0))
        channel.activate()
        ready.release()
        got = 0
        while got < count:
            if objects:
                new = len(channel.receive_many(1000, PATIENCE_S))
            else:
                channel.reading.threshold = min(2048, count - got)
                new = len(channel.receive_array(None, PATIENCE_S))
            if new == 0:
                break
            got += new
        results.put((got, channel.status().lost))


def throughput(count: int, receivers: int, *, objects: bool = False) -> tuple[float, int]:
    """Frames/s delivered to all receivers together, sender, hub and receivers in processes of their own; lost ones."""
    ready, results = CONTEXT.Semaphore(0), CONTEXT.Queue()
    with served("fast") as hub_process, running(hub_process.address) as (hub, board):
        arguments = (hub_process.address, ready, results, count, objects)
        processes = [CONTEXT.Process(target=receive, args=arguments) for _ in range(receivers)]
        for process in processes:
            process.start()
        for _ in processes:
            ready.acquire()
        began = time.perf_counter()
        pour(sender(hub, board), count)
        outcomes = [results.get() for _ in processes]
        spent = time.perf_counter() - began
        for process in processes:
            process.join()
    missing = sum(count - got for got, _ in outcomes) + sum(lost for _, lost in outcomes)
    return count * receivers / spent, missing


def listen(address: str, ready: Semaphore, results: Any, count: int) -> None:
    """A receiving process: how long each frame was on its way, from the time that its data holds."""
    with canwire.connect(address) as hub:
        channel = hub.open_channel(hub.boards()[0].id, 1)
        channel.set_up(canwire.ChannelMode(BATCH, 0))
        channel.activate()
        ready.release()
        ways = []
        for _ in range(count):
            frame = channel.receive(PATIENCE_S)
            assert frame is not None
            ways.append(time.perf_counter_ns() - int.from_bytes(frame.data, "little"))
        results.put(ways)


def latency(seconds: float) -> tuple[float, float]:
    """p50 and p99 in us from one process to another at 1,000 frames/s, the bus not paced."""
    count = round(1000 * seconds)
    ready, results = CONTEXT.Semaphore(0), CONTEXT.Queue()
    with served("fast") as hub_process, running(hub_process.address) as (hub, board):
        process = CONTEXT.Process(target=listen, args=(hub_process.address, ready, results, count))
        process.start()
        ready.acquire()
        channel = sender(hub, board)
        for stamp in paced(count):
            channel.send(canwire.Frame(0x100, stamp.to_bytes(8, "little")))
        ways = results.get()
        process.join()
    return percentiles(ways)


def paced(count: int) -> Iterator[int]:
    """The time in ns, every millisecond."""
    due = time.perf_counter()
    for _ in range(count):
        due += 0.001
        time.sleep(max(0.0, due - time.perf_counter()))
        yield time.perf_counter_ns()


def percentiles(nanoseconds: list[int]) -> tuple[float, float]:
    """p50 and p99 in us."""
    hundredths = statistics.quantiles(nanoseconds, n=100)
    return hundredths[49] / 1000, hundredths[98] / 1000


def soak(address: str, ready: Semaphore, results: Any) -> None:
    """A receiving process that takes everything until nothing has come for two seconds."""
    with canwire.connect(address) as hub:
        channel = hub.open_channel(hub.boards()[0].id, 1)
        channel.set_up(canwire.ChannelMode(QUEUE, 0))
        channel.activate()
        ready.release()
        got = 0
        while new := len(channel.receive_array(None, 2.0)):
            got += new
        results.put((got, channel.status().lost))


def real_time(seconds: float, clients: int = 4) -> tuple[float, float, int]:
    """A saturated bus at 1 Mbit/s with four clients: the hub's share of a core in %, frames/s, frames lost."""
    ready, results = CONTEXT.Semaphore(0), CONTEXT.Queue()
    with served("real") as hub_process, running(hub_process.address) as (hub, board):
        processes = [
            CONTEXT.Process(target=soak, args=(hub_process.address, ready, results)) for _ in range(clients)
        ]
        for process in processes:
            process.start()
        for _ in processes:
            ready.acquire()
        channel = sender(hub, board)
        used, began = hub_process.processor_s(), time.perf_counter()
        pour(channel, round(8500 * seconds))
        while channel.status().pending:
            time.sleep(0.05)
        spent = time.perf_counter() - began
        share = 100 * (hub_process.processor_s() - used) / spent
        sent = channel.status().delivered
        outcomes = [results.get() for _ in processes]
        for process in processes:
            process.join()
    return share, sent / spent, sum(sent - got + lost for got, lost in outcomes)


def many_channels(channels: int, count: int) -> tuple[float, float]:
    """Channels on one line: ns for each copy delivered, and KB of the hub for each beyond its rings' pages."""
    with served("fast") as hub_process, running(hub_process.address) as (hub, board):
        pour(warm := sender(hub, board), BATCH)
        warm.close()
        before = hub_process.resident_bytes()
        opened = []
        for _ in range(channels):
            channel = hub.open_channel(board, 1)
            channel.set_up(canwire.ChannelMode(BATCH, 0))
            channel.activate()
            opened.append(channel)
        each = (hub_process.resident_bytes() - before) / channels
        used = hub_process.processor_s()
        out = sender(hub, board)
        for _ in range(count // (BATCH // 2)):
            pour(out, BATCH // 2)
            for channel in opened:
                channel.reading.threshold = BATCH // 2
                channel.receive_array(None, PATIENCE_S)
        spent = hub_process.processor_s() - used
    return 1e9 * spent / (count * channels), each / 1024


def multicast_listen(ready: Semaphore, results: Any, seconds: float) -> None:
    import can

    with can.Bus(interface="udp_multicast", channel=MULTICAST) as bus:
        ready.release()
        ways, first = [], time.perf_counter()
        last = first
        while (message := bus.recv(seconds)) is not None:
            last = time.perf_counter()
            first = first if ways else last
            ways.append(time.perf_counter_ns() - int.from_bytes(message.data, "little"))
        results.put((len(ways), last - first, percentiles(ways) if len(ways) > 1 else (0.0, 0.0)))


def multicast(count: int, *, paced_sending: bool) -> tuple[float, float, tuple[float, float]]:
    """python-can's udp_multicast from one process to another: frames/s received, % lost, p50 and p99 in us."""
    import can

    ready, results = CONTEXT.Semaphore(0), CONTEXT.Queue()
    process = CONTEXT.Process(target=multicast_listen, args=(ready, results, 2.0))
    process.start()
    ready.acquire()
    with can.Bus(interface="udp_multicast", channel=MULTICAST) as bus:
        stamps = paced(count) if paced_sending else (time.perf_counter_ns() for _ in range(count))
        for stamp in stamps:
            bus.send(
                can.Message(arbitration_id=0x100, data=stamp.to_bytes(8, "little"), is_extended_id=False)
            )
        got, spent, ways = results.get()
    process.join()
    return got / max(spent, 1e-9), 100 * (count - got) / count, ways


def rows(scale: int, seconds: float) -> list[tuple[str, str, str, str]]:
    """For the table of run.py."""
    count = 2_000_000 // scale
    theirs, lost, _ = multicast(100_000 // scale, paced_sending=False)
    beside = f"udp_multicast {theirs:,.0f}/s, {lost:.0f} % lost"
    table = []
    for what, receivers, objects, goal in (
        ("process to process, batches", 1, False, "1,500,000"),
        ("  one object a frame", 1, True, "250,000"),
        ("  one sender to eight processes, batches", 8, False, "4,000,000"),
    ):
        speed, missing = throughput(count, receivers, objects=objects)
        table.append((what, f"{speed:,.0f} frames/s, {missing} lost", beside, goal))
    ours, theirs_ways = latency(seconds), multicast(round(1000 * seconds), paced_sending=True)[2]
    table.append(
        (
            "  one way at 1,000 frames/s (p50 / p99)",
            f"{ours[0]:.0f} / {ours[1]:.0f} us",
            f"udp_multicast {theirs_ways[0]:.0f} / {theirs_ways[1]:.0f} us",
            "40 / 130 us",
        )
    )
    share, speed, missing = real_time(seconds)
    table.append(
        (
            "real time, 1 Mbit/s saturated, 4 clients",
            f"hub {share:.0f} % of a core, {speed:,.0f} frames/s, {missing} lost",
            "",
            "< 25 %, 0 lost",
        )
    )
    for channels in (10, 100):
        cost, kilobytes = many_channels(channels, 40_000 // scale)
        table.append(
            (
                f"{channels} channels on a line",
                f"{cost:.0f} ns a copy, {kilobytes:.1f} KB each",
                "",
                "< 16 KB each",
            )
        )
    return table
