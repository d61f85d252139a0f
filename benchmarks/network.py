"""A hub on another machine, over this machine's loopback, beside bare Zenoh with payloads of the same size.

Three processes in each case: who sends, who offers, who receives. What passes is a FIFO's elements of 80 bytes, a
frame's record: no bus takes part, so the link alone is measured. `python benchmarks/network.py`.
"""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from typing import Any

import canwire

CONTEXT = multiprocessing.get_context("spawn")
RECORD = 80
BATCH = 64
MANY = 4  # batches that canwire sends together where so many wait
QUEUE = 1 << 15
SPAN_S = 3.0
PACED = 3_000
PATIENCE_S = 30.0


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


@contextlib.contextmanager
def offered() -> Iterator[tuple[str, str]]:
    """`canwire serve --network`: the hub's socket, and its address on the network."""
    with tempfile.TemporaryDirectory() as folder:
        port = free_port()
        path = f"{folder}/hub.sock"
        command = [sys.executable, "-m", "canwire", "serve", "--socket", path, "--time", "fast", "--network"]
        command += ["--realm", "bench", "--name", "bench", "--listen", f"tcp/127.0.0.1:{port}"]
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
            assert process.stdout is not None
            process.stdout.readline()
            try:
                yield path, f"zenoh://bench/bench?via=tcp/127.0.0.1:{port}"
            finally:
                process.terminate()


# bare Zenoh


def session(mode: str, port: int) -> Any:
    import zenoh

    config = zenoh.Config()
    settings: dict[str, Any] = {"mode": mode, "scouting/multicast/enabled": False}
    settings["transport/shared_memory/enabled"] = False
    settings["listen/endpoints" if mode == "peer" else "connect/endpoints"] = [f"tcp/127.0.0.1:{port}"]
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def bare_sender(port: int, size: int, gap_s: float, ready: Any, stop: Any) -> None:
    import zenoh

    with session("client", port) as own:
        publisher = own.declare_publisher(
            "bench/x", congestion_control=zenoh.CongestionControl.BLOCK, express=gap_s > 0
        )
        ready.wait(PATIENCE_S)
        rest = bytes(size - 8)
        while not stop.is_set():
            for _ in range(1 if gap_s else 100):
                publisher.put(time.monotonic_ns().to_bytes(8, "little") + rest)
            if gap_s:
                time.sleep(gap_s)


def bare(size: int, *, paced: bool) -> tuple[float, list[int]]:
    """Payloads a second; and how long each was under way, in nanoseconds."""
    import zenoh

    port, ready, stop = free_port(), CONTEXT.Event(), CONTEXT.Event()
    arrived: list[int] = []
    count = 0

    def came(sample: Any) -> None:
        nonlocal count
        payload = sample.payload.to_bytes()
        count += 1
        if paced:
            arrived.append(time.monotonic_ns() - int.from_bytes(payload[:8], "little"))

    with session("peer", port) as own:
        own.declare_subscriber("bench/x", zenoh.handlers.Callback(came, indirect=False))
        process = CONTEXT.Process(target=bare_sender, args=(port, size, 0.001 if paced else 0, ready, stop))
        process.start()
        ready.set()
        while not count:
            time.sleep(0.01)
        began, before = time.perf_counter(), count
        while (len(arrived) < PACED) if paced else (time.perf_counter() - began < SPAN_S):
            time.sleep(0.05)
        rate = (count - before) / (time.perf_counter() - began)
        stop.set()
        process.join(PATIENCE_S)
    return rate, arrived


# canwire


def writer(address: str, number: int, gap_s: float, single: bool, stop: Any) -> None:
    """A program beside the hub that fills a FIFO: in batches, one by one, or at a pace."""
    with canwire.connect(address) as hub, hub.open_fifo(number, "writer") as fifo:
        end = fifo.end_of_ring
        ring, rest = end.ring, bytes(RECORD - 8)
        while not stop.is_set():
            if gap_s or single:
                if ring.free():
                    ring.put_bytes(time.monotonic_ns().to_bytes(8, "little") + rest)
                else:
                    end.wait(0.1)
                if gap_s:
                    time.sleep(gap_s)
            elif room := len(ring.acquire_free(4096)) // RECORD:
                ring.commit(room)
            else:
                end.threshold = 1024
                end.wait(0.1)


def over(address: str, local: str, *, gap_s: float = 0.0, single: bool = False) -> tuple[float, list[int]]:
    """Elements a second at `address`, written beside the hub; and how long each was under way."""
    stop = CONTEXT.Event()
    arrived: list[int] = []
    with (
        canwire.connect(local) as here,
        here.create_fifo(QUEUE, RECORD) as made,
        canwire.connect(address) as hub,
        hub.open_fifo(made.id, "reader") as fifo,
    ):
        process = CONTEXT.Process(target=writer, args=(local, made.id, gap_s, single, stop))
        process.start()
        end = fifo.end_of_ring
        assert end.wait(PATIENCE_S)
        end.threshold = 1 if single or gap_s else 16 * BATCH
        began, count = time.perf_counter(), 0
        while (len(arrived) < PACED) if gap_s else (time.perf_counter() - began < SPAN_S):
            if not end.ring.fill():
                end.wait(1.0)
            elif single or gap_s:
                record = end.ring.take_bytes()
                assert record is not None
                count += 1
                if gap_s:
                    arrived.append(time.monotonic_ns() - int.from_bytes(record[:8], "little"))
            else:
                taken = sum(len(block) for block in end.ring.acquire(4096)) // RECORD
                end.ring.release(taken)
                count += taken
        rate = count / (time.perf_counter() - began)
        stop.set()
        process.join(PATIENCE_S)
    return rate, arrived


def under_way(found: list[int]) -> str:
    cuts = statistics.quantiles(found, n=100)
    return f"{cuts[49] / 1000:8.0f} us p50 {cuts[98] / 1000:8.0f} us p99"


def calls(address: str) -> str:
    found = []
    with canwire.connect(address) as hub:
        for _ in range(1000):
            began = time.monotonic_ns()
            hub.now_ns()
            found.append(time.monotonic_ns() - began)
    return under_way(found)


def main() -> None:
    payload = BATCH * RECORD
    with offered() as (local, address):
        for _ in range(3):
            rate, _ = bare(payload, paced=False)
            many, _ = bare(MANY * payload, paced=False)
            mine, _ = over(address, local)
            single, _ = over(address, local, single=True)
            print(f"bare Zenoh, {payload} bytes a payload {rate * BATCH:12,.0f} frames/s")
            print(f"bare Zenoh, {MANY * payload} bytes            {many * BATCH * MANY:12,.0f} frames/s")
            print(
                f"canwire, batches                  {mine:12,.0f} frames/s ({mine / rate / BATCH:.2f} of bare)"
            )
            print(f"canwire, one object a frame       {single:12,.0f} frames/s")
        for _ in range(2):
            _, bare_ns = bare(RECORD, paced=True)
            _, own_ns = over(address, local, gap_s=0.001)
            ratio = statistics.median(own_ns) / statistics.median(bare_ns)
            print(f"bare Zenoh, one way at 1,000/s  {under_way(bare_ns)}")
            print(f"canwire, one way at 1,000/s     {under_way(own_ns)} ({ratio:.1f} times)")
        print(f"a call over the network         {calls(address)}")
        print(f"a call over the socket          {calls(local)}")


if __name__ == "__main__":
    main()
