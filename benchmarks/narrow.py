"""Programs on another machine that read a busy line over a narrow network, each with a copy of its own or by a relay.

python benchmarks/narrow.py [--programs 5] [--rate 1500] [--bytes 50000] [--seconds 20] [--random] [--direct] [--cut S]

Two machines in network namespaces, joined by the tests' spoiler, which lets so many bytes/s pass in each direction.
For each reader: frames received, frames that the hub counted as lost, and frames missing between first and last.
`--cut` cuts the network in both directions meanwhile.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

from tests.machines.namespaces import Machine, machines

_HUB = "10.77.0.1"
_READER = """
import json, sys, time, canwire
from canwire import ChannelMode
with canwire.connect(sys.argv[1]) as hub:
    with hub.open_channel(hub.boards()[0].id, 0) as channel:
        channel.set_up(ChannelMode(receive=32768, transmit=0))
        channel.activate()
        print("reads", flush=True)
        got, last, missing, until = 0, None, 0, None
        while until is None or time.time() < until:
            frames = channel.receive_many(10_000, timeout=1.0)
            now = time.time()
            if frames and until is None:
                until = now + float(sys.argv[2])
            got += len(frames)
            for frame in frames:
                number = int.from_bytes(frame.data[:2], "little")
                missing += 0 if last is None else (number - last - 1) % 65536
                last = number
        print(json.dumps({"frames": got, "lost": channel.status().lost, "missing": missing}), flush=True)
"""
_WRITER = """
import random, sys, time, canwire
from canwire import BitTiming, ChannelMode, Frame, LineMode
rate, mixed = float(sys.argv[2]), sys.argv[3] == "1"
timing = BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)
dice = random.Random(1)
with canwire.connect(sys.argv[1]) as hub:
    for board in hub.boards():
        control = hub.open_control(board.id, 0)
        control.initialise(LineMode(timing=timing))
        control.start()
        hub.keep_settings(board.id, 0)
    with hub.open_channel(hub.boards()[1].id, 0) as channel:
        channel.set_up(ChannelMode(receive=16, transmit=1024))
        channel.activate()
        print("ready", flush=True)
        began, sent = time.monotonic(), 0
        while True:
            due = int((time.monotonic() - began) * rate) - sent
            for k in range(sent, sent + due):
                rest = dice.randbytes(6) if mixed else bytes(6)
                data = (k & 65535).to_bytes(2, "little") + rest
                channel.send(Frame(0x100 + k % 16, data))
            sent += due
            time.sleep(0.005)
"""
_CONFIG = """
[[bus]]
name = "can0"

[[board]]
kind = "usb-to-can-fd"
serial = "HW000001"

[[board]]
kind = "usb-to-can-fd"
serial = "HW000002"
"""


def started(machine: Machine, stack: ExitStack, *words: str) -> subprocess.Popen[str]:
    """A program on that machine, and its first line."""
    command = machine.words([sys.executable, "-u", *words])
    process = stack.enter_context(subprocess.Popen(command, stdout=subprocess.PIPE, text=True))
    stack.callback(process.terminate)
    assert process.stdout is not None
    print("   ", process.stdout.readline().strip(), flush=True)
    return process


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--programs", type=int, default=5)
    parser.add_argument("--rate", type=int, default=1_500)
    parser.add_argument("--bytes", type=float, default=50_000)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--random", action="store_true")
    parser.add_argument("--direct", action="store_true")
    parser.add_argument("--cut", type=float, default=0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place, machines(2) as (found, spoiler), ExitStack() as stack:
        folder = Path(place)
        (folder / "bench.toml").write_text(_CONFIG)
        local = str(folder / "hub.sock")
        offer = ["--network", "--realm", "lab", "--name", "bench1", "--listen", f"tcp/{_HUB}:7449"]
        offer += ["--relay", f"tcp/{_HUB}:7450", "--insecure"]
        serve = ["-m", "canwire", "serve", "--socket", local, "--config", str(folder / "bench.toml"), *offer]
        started(found[0], stack, *serve)
        address = f"zenoh://lab/{_HUB}"
        if not options.direct:
            started(found[1], stack, "-m", "canwire", "relay", f"tcp/{_HUB}:7450")
            address = "zenoh://lab/bench1?relay=tcp/127.0.0.1:7448"
        for way in spoiler.ways.values():
            way.rate = options.bytes
        readers = [
            started(found[1], stack, "-c", _READER, address, str(options.seconds))
            for _ in range(options.programs)
        ]
        started(found[0], stack, "-c", _WRITER, local, str(options.rate), str(int(options.random)))
        if options.cut:
            time.sleep(2)
            for way in spoiler.ways.values():
                way.cut = True
            time.sleep(options.cut)
            for way in spoiler.ways.values():
                way.cut = False
        for reader in readers:
            assert reader.stdout is not None
            said = json.loads(reader.stdout.readline())
            print(
                f"{said['frames'] / options.seconds:.0f} frames/s, {said['lost']} lost, {said['missing']} missing"
            )


if __name__ == "__main__":
    main()
