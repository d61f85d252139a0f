"""One time for many programs: steps a second, beside bare pipes that hand a word round in the same way.

    python benchmarks/lockstep.py [--programs 2 20] [--network] [--silkit PYTHON]

A step is 1 ms of the hub's time, in which every program has one turn: each sleeps so long, again and again. The bare
pipes do as many handovers and nothing else: one process writes a byte to each of the others in turn, and waits for its
answer. Both run in the same run, one after the other; best of `--repeat`, with the processor time that all their
processes took for a turn. With `--network` the programs reach the hub
over it, and beside them stands Zenoh's bare query and answer between two processes, one for each turn. With `--silkit`
participants of SIL Kit have as many steps, in an interpreter that has silkit-py (benchmarks/silkit.py).
"""

from __future__ import annotations

import argparse
import contextlib
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from silkit import steps_a_second

import canwire

_PROGRAM = """
import sys, time, canwire

def connected():
    for _ in range(20):  # where many start at once, the hub may not answer within its two seconds
        try:
            return canwire.connect(timed=True)
        except canwire.HubLost:
            pass
    raise SystemExit("the hub does not answer")

with connected() as hub:
    began_s = time.process_time()
    for _ in range(int(sys.argv[1])):
        hub.sleep(0.001)
    print(time.process_time() - began_s)
"""


_QUERYABLE = """
import sys, zenoh
config = zenoh.Config.from_json5(sys.argv[1])
with zenoh.open(config) as session:
    def answer(query):
        query.reply(query.key_expr, query.payload.to_bytes())
        query.drop()
    session.declare_queryable("bare", zenoh.handlers.Callback(answer, indirect=False), complete=True)
    print("ready", flush=True)
    sys.stdin.read()
"""


class Pace(NamedTuple):
    """Steps a second, and microseconds of the processor for each turn."""

    rate: float
    turn_us: float


@contextlib.contextmanager
def offered(hub: str) -> Iterator[str]:
    """The hub's address on this machine's loopback."""
    place = f"tcp/127.0.0.1:{free_port()}"
    command = [sys.executable, "-m", "canwire", "offer", "--hub", hub, "--realm", "bench", "--listen", place]
    process = subprocess.Popen([*command, "--name", "bench"], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        process.stdout.readline()
        yield f"zenoh://bench/bench?via={place}"
    finally:
        process.terminate()
        process.wait(30)
        process.stdout.close()


def free_port() -> int:
    """A port of the loopback that nobody listens on."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


def queries(programs: int, steps: int) -> Pace:
    """One Zenoh query and its answer for each program, one after the other."""
    import zenoh

    place = f"tcp/127.0.0.1:{free_port()}"
    quiet = '"scouting": {"multicast": {"enabled": false}, "gossip": {"enabled": false}}'
    listens = f'{{"mode": "peer", "listen": {{"endpoints": ["{place}"]}}, {quiet}}}'
    dials = f'{{"mode": "client", "connect": {{"endpoints": ["{place}"]}}, {quiet}}}'
    other = subprocess.Popen(
        [sys.executable, "-c", _QUERYABLE, listens], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert other.stdin is not None
    assert other.stdout is not None
    other.stdout.readline()
    gate = threading.Lock()
    gate.acquire()

    def answered(reply: Any) -> None:
        gate.release()

    with zenoh.open(zenoh.Config.from_json5(dials)) as session:
        begin_s, before_s = time.perf_counter(), time.process_time()
        for _ in range(steps * programs):
            handler = zenoh.handlers.Callback(answered, indirect=False)
            session.get("bare", handler, payload=b"turn", express=True)
            gate.acquire()
        taken_s, spent_s = time.perf_counter() - begin_s, time.process_time() - before_s + used_s(other.pid)
    other.stdin.close()
    other.wait(30)
    other.stdout.close()
    return Pace(steps / taken_s, spent_s / steps / programs * 1e6)


def used_s(process: int) -> float:
    """Of the processor, by all of its threads so far."""
    tasks = Path(f"/proc/{process}/task")
    return sum(int(path.read_text().split()[0]) for path in tasks.glob("*/schedstat")) / 1e9


def lockstep(programs: int, steps: int, *, network: bool = False) -> Pace:
    """From the first turn to the last program's end; a hub in a process of its own."""
    with tempfile.TemporaryDirectory() as home:
        address = str(Path(home) / "hub.sock")
        serve = [sys.executable, "-m", "canwire", "serve", "--time", "lockstep", "--socket", address]
        hub = subprocess.Popen([*serve, "--programs", str(programs + 1)], stdout=subprocess.PIPE, text=True,
                               stderr=subprocess.DEVNULL)  # fmt: skip
        assert hub.stdout is not None
        hub.stdout.readline()
        others: list[subprocess.Popen[str]] = []
        with contextlib.ExitStack() as stack:
            stack.callback(_ended, hub, others)
            reached = stack.enter_context(offered(address)) if network else address
            others += [
                subprocess.Popen(
                    [sys.executable, "-c", _PROGRAM, str(steps)],
                    env={**os.environ, "CANWIRE_HUB": reached, "CANWIRE_NAME": f"program {number}"},
                    stdout=subprocess.PIPE,
                    text=True,
                )
                for number in range(programs)
            ]
            with canwire.connect(address, timed=True, name="a clock") as clock:
                begin_s, before_s = time.perf_counter(), used_s(hub.pid)
                clock.sleep(steps / 1000)
                taken_s, spent_s = time.perf_counter() - begin_s, used_s(hub.pid) - before_s
            spent_s += sum(float(one.communicate(timeout=60)[0]) for one in others)
    return Pace(steps / taken_s, spent_s / steps / programs * 1e6)


def _ended(hub: subprocess.Popen[str], others: list[subprocess.Popen[str]]) -> None:
    for one in others:
        one.kill()
        one.wait(30)
    hub.terminate()
    hub.wait(30)
    assert hub.stdout is not None
    hub.stdout.close()


def pipes(programs: int, steps: int) -> Pace:
    """A byte goes to each process and back, by pipes alone."""
    there, back = [os.pipe() for _ in range(programs)], [os.pipe() for _ in range(programs)]
    children = []
    for number in range(programs):
        child = os.fork()
        if child == 0:
            for _ in range(steps):
                os.read(there[number][0], 1)
                os.write(back[number][1], b".")
            os._exit(0)
        children.append(child)
    begin_s, before_s = time.perf_counter(), sum(os.times()[:4])
    for _ in range(steps):
        for number in range(programs):
            os.write(there[number][1], b".")
            os.read(back[number][0], 1)
    taken_s = time.perf_counter() - begin_s
    for child in children:
        os.waitpid(child, 0)
    spent_s = sum(os.times()[:4]) - before_s  # of the children, too, which have ended
    for reading, writing in there + back:
        os.close(reading)
        os.close(writing)
    return Pace(steps / taken_s, spent_s / steps / programs * 1e6)


def main() -> None:
    """Print one row for each number of programs."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--programs", type=int, nargs="+", default=[2, 20])
    parser.add_argument("--steps", type=int, default=20_000, help="turns of all programs together, each time")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--network", action="store_true", help="beside Zenoh's bare queries, not pipes")
    parser.add_argument("--silkit", metavar="PYTHON", help="an interpreter that has silkit-py")
    arguments = parser.parse_args()
    assert threading.active_count() == 1, "pipes() forks"
    for programs in arguments.programs:
        steps = max(1, arguments.steps // programs)
        beside = queries if arguments.network else pipes
        bare = best([beside(programs, steps) for _ in range(arguments.repeat)])
        ours = best([lockstep(programs, steps, network=arguments.network) for _ in range(arguments.repeat)])
        print(
            f"{programs:3} processes: {ours.rate:8,.0f} steps/s, {ours.turn_us:5.1f} us a turn; "
            f"bare {beside.__name__} {bare.rate:8,.0f}, {bare.turn_us:5.1f} us; load {os.getloadavg()[0]:.1f}",
            flush=True,
        )
        if arguments.silkit:
            rate = max(steps_a_second(arguments.silkit, programs, steps) for _ in range(arguments.repeat))
            print(f"{'':13}  {rate:8,.0f} steps/s with SIL Kit", flush=True)


def best(found: list[Pace]) -> Pace:
    """Of each figure."""
    return Pace(max(one.rate for one in found), min(one.turn_us for one in found))


if __name__ == "__main__":
    main()
