"""What is measured: each function runs once and returns a figure. Nothing here prints or chooses."""

from __future__ import annotations

import gc
import random
import resource
import time
from collections.abc import Callable
from pathlib import Path

import canwire
from canwire import Frame, Lab

NODES = 4
BATCH = 1000


def mixed_frames(node: int, count: int, *, fd: bool) -> list[Frame]:
    """Half 11-bit, half 29-bit; 0..8 bytes, with `fd` 8..64; no identifier is shared between nodes."""
    chance = random.Random(node)
    frames = []
    for _ in range(count):
        extended = chance.random() < 0.5
        length = chance.choice((8, 12, 16, 20, 24, 32, 48, 64)) if fd else chance.randrange(9)
        id = (chance.randrange(1 << 27) if extended else chance.randrange(1 << 9)) << 2 | node
        data = chance.randbytes(length)
        frames.append(Frame(id, data, extended=extended, fd=fd, bit_rate_switch=fd))
    return frames


def saturated(count: int, *, fd: bool = False, filters: bool = True) -> tuple[float, float, float]:
    """Four nodes send all they can at 1 Mbit/s, each with a filter that lets half of the others' frames in.

    Returns frames/s on the bus, bus time over wall time, and records/s drained as numpy batches.
    """
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=1_000_000, data_bit_rate=4_000_000)
        halves = [(0x000, 0x004), (0x000, 0x004, True)]
        nodes = [
            bus.node(
                f"n{k}", filters=halves if filters else None, receive_queue=4 * BATCH, transmit_queue=BATCH
            )
            for k in range(NODES)
        ]
        batches = [canwire.frames_to_array(mixed_frames(k, BATCH // NODES, fd=fd)) for k in range(NODES)]
        running = draining = 0.0
        drained = 0
        for _ in range(max(1, count // BATCH)):
            for node, batch in zip(nodes, batches, strict=True):
                node.send_array(batch)
            began = time.perf_counter()
            lab.run_until_idle()
            running += time.perf_counter() - began
            began = time.perf_counter()
            for node in nodes:
                drained += len(node.receive_array())
            draining += time.perf_counter() - began
        assert all(node.lost == 0 for node in nodes)
        assert bus.error_frames == 0
        return bus.frames / running, lab.now_ns / 1e9 / running, drained / draining


def lab_objects(count: int, receivers: int) -> float:
    """Frame objects one by one from a sender; every receiver takes every frame as an object. Frames sent/s."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=1_000_000)
        sender = bus.node("sender", receive_queue=1)
        takers = [bus.node(f"r{k}") for k in range(receivers)]
        began = time.perf_counter()
        for start in range(0, count, 100):
            for k in range(start, start + 100):
                sender.send(Frame(k & 0x7FF, b"\x11\x22\x33\x44"))
            lab.run_until_idle()
            for taker in takers:
                assert len(taker.receive_many(1000)) == 100
        return count / (time.perf_counter() - began)


def lab_arrays(count: int) -> float:
    """The same, one to one, sent and received as numpy records: arbitration, bits and all. Frames/s."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=1_000_000)
        sender, taker = bus.node("sender", receive_queue=1), bus.node("taker")
        batch = canwire.frames_to_array([Frame(k & 0x7FF, b"\x11\x22\x33\x44") for k in range(BATCH)])
        received = 0
        began = time.perf_counter()
        for _ in range(max(1, count // len(batch))):
            sender.send_array(batch)
            lab.run_until_idle()
            received += len(taker.receive_array())
        return received / (time.perf_counter() - began)


def draining(count: int, take: str) -> float:
    """Only the taking: frames/s out of a full receive queue, as "objects" or as "arrays"."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=1_000_000)
        sender, taker = bus.node("sender", receive_queue=1), bus.node("taker")
        batch = canwire.frames_to_array([Frame(k & 0x7FF, b"\x11\x22\x33\x44") for k in range(10_000)])
        spent, received = 0.0, 0
        for _ in range(max(1, count // len(batch))):
            sender.send_array(batch)
            lab.run_until_idle()
            began = time.perf_counter()
            while taker.waiting:
                received += len(taker.receive_array(BATCH) if take == "arrays" else taker.receive_many(BATCH))
            spent += time.perf_counter() - began
        return received / spent


def python_can(count: int, receivers: int) -> float:
    """python-can's virtual bus doing the same: frames sent/s, each received by everybody."""
    import can

    channel = object()
    with can.Bus(interface="virtual", channel=channel) as sender:
        takers = [can.Bus(interface="virtual", channel=channel) for _ in range(receivers)]
        began = time.perf_counter()
        for start in range(0, count, 100):
            for k in range(start, start + 100):
                message = can.Message(
                    arbitration_id=k & 0x7FF, data=b"\x11\x22\x33\x44", is_extended_id=False
                )
                sender.send(message)
            for taker in takers:
                for _ in range(100):
                    assert taker.recv(0) is not None
        rate = count / (time.perf_counter() - began)
        for taker in takers:
            taker.shutdown()
        return rate


def python_can_draining(count: int) -> float:
    """Only the taking: messages/s out of a python-can virtual bus's queue."""
    import can

    channel = object()
    with (
        can.Bus(interface="virtual", channel=channel) as sender,
        can.Bus(interface="virtual", channel=channel) as taker,
    ):
        for k in range(count):
            sender.send(can.Message(arbitration_id=k & 0x7FF, data=b"\x11\x22\x33\x44", is_extended_id=False))
        began = time.perf_counter()
        for _ in range(count):
            assert taker.recv(0) is not None
        return count / (time.perf_counter() - began)


def hour_at_half_load(seconds: float) -> float:
    """A periodic schedule that fills half of a 500 kbit/s bus, for this much bus time; bus time over wall time."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        sender, taker = bus.node("sender"), bus.node("taker")
        frame = Frame(0x123, bytes.fromhex("DEADBEEF"))
        period_ns = 2 * 81 * 2000  # 78 bits of frame, 3 of intermission

        def turn() -> None:
            sender.send(frame)
            lab.at(lab.timeline.now_ns + period_ns, turn, background=True)

        lab.at(0, turn, background=True)
        began = time.perf_counter()
        while lab.now_ns < seconds * 1e9:
            lab.run_for(1.0)
            taker.receive_array()
        spent = time.perf_counter() - began
        assert 49.0 < bus.mean_load < 51.0
        return lab.now_ns / 1e9 / spent


def bit_by_bit(count: int, nodes_there: int = NODES) -> float:
    """The slow way, that errors and VCD traces take: frames/s; four of the nodes send."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=1_000_000)
        nodes = [bus.node(f"n{k}") for k in range(nodes_there)]
        bus.wire.bitwise = True
        for k in range(count):
            nodes[k % NODES].send(Frame(0x100 + k % NODES, b"\x11\x22\x33\x44"))
        began = time.perf_counter()
        lab.run_until_idle()
        return count / (time.perf_counter() - began)


def with_errors(count: int, share: float) -> float:
    """Noise that meets this share of the frames, which are repeated then: frames/s that get through, four nodes."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=1_000_000)
        nodes = [bus.node(f"n{k}") for k in range(NODES)]
        bus.faults.noise(1 - (1 - share) ** (1 / 82))  # bits of these frames
        for k in range(count):
            nodes[k % NODES].send(Frame(0x100 + k % NODES, b"\x11\x22\x33\x44"))
        began = time.perf_counter()
        lab.run_until_idle()
        return bus.frames / (time.perf_counter() - began)


def lateness(seconds: float) -> tuple[float, float]:
    """Real time, 1,000 frames/s: microseconds that frame ends are late, p50 and p99."""
    with Lab(time="real") as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        sender, _ = bus.node("sender"), bus.node("taker")
        for k in range(round(seconds * 1000)):
            lab.at(k * 1_000_000, lambda: sender.send(Frame(0x123)))
        lab.run_for(seconds)
        late = sorted(lab.lateness_ns())
        return late[len(late) // 2] / 1000, late[len(late) * 99 // 100] / 1000


def sleep_lateness(seconds: float) -> tuple[float, float]:
    """How late this machine wakes a bare sleep of a millisecond, in microseconds, p50 and p99."""
    late = []
    for _ in range(round(seconds * 1000)):
        due = time.monotonic_ns() + 1_000_000
        time.sleep(0.001)
        late.append(time.monotonic_ns() - due)
    late.sort()
    return late[len(late) // 2] / 1000, late[len(late) * 99 // 100] / 1000


def resident_megabytes() -> float:
    """Resident memory of this process with a Lab of ten nodes that have exchanged frames."""
    with Lab() as lab:
        bus = lab.can_bus("can0")
        nodes = [bus.node(f"n{k}") for k in range(10)]
        for k, node in enumerate(nodes):
            node.send(Frame(k))
        lab.run_until_idle()
        gc.collect()
        return resident_now()


def resident_now() -> float:
    """Megabytes; where /proc is missing, the most there ever were, which may count a parent's."""
    status = Path("/proc/self/status")
    if status.exists():
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmRSS:"))
        return int(line.split()[1]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def median(measure: Callable[[], float], runs: int) -> float:
    return sorted(measure() for _ in range(runs))[runs // 2]
