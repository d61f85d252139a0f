"""What users write: twenty nodes in Python that answer each other, beside the same program on SimPy and python-can.

    python benchmarks/nodes.py [--frames N] [--runs N]

Node 0 begins; node k waits for the frame of node k-1 and answers with its own, round and round; each node also looks
at a timer of 10 ms. canwire's lab has bits, arbitration and acknowledges of a bus at 1 Mbit/s; SimPy has a bus that
takes a frame's nominal time and hands it to everybody; python-can's virtual bus has twenty threads and no time. Frames
per second of processor time, so that other work on the machine does not count; medians. Needs canwire[bench].
"""

from __future__ import annotations

import argparse
import itertools
import statistics
import threading
import time
from collections.abc import Callable, Generator
from typing import Any

import canwire
from canwire import Frame, Lab, NodeScript

NODES = 20
FIRST_ID = 0x100
PAYLOAD = bytes(8)
FRAME_S = 111e-6  # 111 bits at 1 Mbit/s
TIMER_S = 0.010
PATIENCE_S = 10.0


class Answering(NodeScript):
    """Answers the frame of the node before it, until enough have passed."""

    def __init__(self, number: int, frames: int) -> None:
        self.waits_for = FIRST_ID + (number - 1) % NODES
        self.answer = Frame(FIRST_ID + number, PAYLOAD)
        self.begins = number == 0
        self.left = frames // NODES
        self.turns = 0

    def on_start(self) -> None:
        self.every(TIMER_S)
        if self.begins:
            self.send(self.answer)

    def on_timer(self) -> None:
        self.turns += 1

    def on_message(self, frame: Frame) -> None:
        if frame.id == self.waits_for and self.left:
            self.left -= 1
            self.send(self.answer)


def canwire_lab(frames: int, *, filtered: bool) -> float:
    """With filters each node sees what it waits for only, as programs on real controllers set them."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=1_000_000)
        scripts = [Answering(number, frames) for number in range(NODES)]
        began = time.process_time()
        for number, script in enumerate(scripts):
            filters = [(script.waits_for, 0x7FF)] if filtered else None
            bus.node(f"n{number}", script, filters=filters)
        while bus.frames < frames and any(script.left for script in scripts):
            lab.run_for(0.1)
        assert bus.frames >= frames
        assert scripts[0].turns > 0
        return bus.frames / (time.process_time() - began)


def simpy_bus(frames: int) -> float:
    """A bus as one writes it in SimPy: a resource that is held for a frame's time, a store for each node."""
    import simpy

    environment = simpy.Environment()
    bus = simpy.PriorityResource(environment)
    stores = [simpy.Store(environment) for _ in range(NODES)]
    sent = itertools.count(1)
    over = environment.event()

    def send(number: int) -> Generator[Any, Any, None]:
        with bus.request(priority=FIRST_ID + number) as request:
            yield request
            yield environment.timeout(FRAME_S)
        for other, store in enumerate(stores):
            if other != number:
                store.put((FIRST_ID + number, PAYLOAD))
        if next(sent) == frames:
            over.succeed()

    def listen(number: int) -> Generator[Any, Any, None]:
        waits_for = FIRST_ID + (number - 1) % NODES
        while True:
            id, _ = yield stores[number].get()
            if id == waits_for:
                environment.process(send(number))

    def timer() -> Generator[Any, Any, None]:
        while True:
            yield environment.timeout(TIMER_S)

    for number in range(NODES):
        environment.process(listen(number))
        environment.process(timer())
    environment.process(send(0))
    began = time.process_time()
    environment.run(over)
    return frames / (time.process_time() - began)


def python_can_threads(frames: int) -> float:
    """python-can's virtual bus, a thread for each node."""
    import can

    channel = object()
    sent = itertools.count(1)
    over = threading.Event()
    buses = [can.Bus(interface="virtual", channel=channel) for _ in range(NODES)]

    def send(number: int) -> None:
        buses[number].send(can.Message(arbitration_id=FIRST_ID + number, data=PAYLOAD, is_extended_id=False))
        if next(sent) >= frames:
            over.set()

    def listen(number: int) -> None:
        waits_for = FIRST_ID + (number - 1) % NODES
        while not over.is_set():
            message = buses[number].recv(TIMER_S)
            if message is not None and message.arbitration_id == waits_for and not over.is_set():
                send(number)

    threads = [threading.Thread(target=listen, args=(number,)) for number in range(NODES)]
    began = time.process_time()
    for thread in threads:
        thread.start()
    send(0)
    over.wait(PATIENCE_S * frames / 1000)
    for thread in threads:
        thread.join()
    spent = time.process_time() - began
    for bus in buses:
        bus.shutdown()
    assert next(sent) > frames, "python-can's ring of nodes has stopped"
    return frames / spent


def median(run: Callable[[], float], runs: int) -> float:
    return statistics.median(run() for _ in range(runs))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=20_000)
    parser.add_argument("--runs", type=int, default=3)
    asked = parser.parse_args()
    print(f"canwire {canwire.__version__}, {canwire.core_mode()}; {NODES} nodes, medians of {asked.runs}")
    ways: list[tuple[str, Callable[[], float]]] = [
        ("python-can, virtual, threads", lambda: python_can_threads(asked.frames // 10)),
        ("SimPy", lambda: simpy_bus(asked.frames)),
        ("canwire, every node sees every frame", lambda: canwire_lab(asked.frames, filtered=False)),
        ("canwire, nodes with filters", lambda: canwire_lab(asked.frames, filtered=True)),
    ]
    beside = None
    for name, run in ways:
        rate = median(run, asked.runs)
        beside = beside or rate
        print(f"{name:40} {rate:>10,.0f} frames/s  {rate / beside:6.1f} x")


if __name__ == "__main__":
    main()
