"""`canwire bridge`: a bus of the hub and an interface of the kernel, or of what stands in for one."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.hubs import LONG_S, serving
from tests.socketcan.bench import Bench, finished, frames

TWO_BUSES = """
[[bus]]
name = "can0"
data_bit_rate = 2000000
[[bus]]
name = "can1"
data_bit_rate = 2000000
[[board]]
kind = "usb-to-can-fd"
buses = ["can0", "can0"]
[[board]]
kind = "usb-to-can-fd"
buses = ["can0", "can0"]
[[board]]
kind = "usb-to-can-fd"
buses = ["can1", "can1"]
"""


@pytest.fixture
def two_buses(tmp_path: Path) -> Iterator[Bench]:
    with serving(tmp_path, TWO_BUSES) as served:
        made = Bench(served, tmp_path)
        yield made
        made.close()


@pytest.mark.conforms("PL-12")
def test_frames_cross_in_both_directions(two_buses: Bench) -> None:
    """The kernel's interface is another bus of the hub, by way of `canwire run`: the bridge cannot tell."""
    bench = two_buses
    here, there = bench.dump("can0", "-l", "-n", "4"), bench.dump("can1", "-l", "-n", "4")
    words = [sys.executable, "-m", "canwire", "bridge", "can0", "vcan0"]
    bridge = bench.start(*words, options=("--interface", "vcan0=can1"))
    assert bridge.stderr is not None
    assert "are one bus now" in bridge.stderr.readline()
    bench.run("sh", "-c", "cansend can0 123#11; cansend can0 124##1AABB")
    bench.run("sh", "-c", "cansend can1 00000125#22; cansend can1 126#R")
    sent = ["123#11", "124##1AABB", "00000125#22", "126#R"]
    assert sorted(frames(finished(here))) == sorted(frames(finished(there))) == sorted(sent)
    bridge.send_signal(signal.SIGINT)
    assert "2 to vcan0, 2 from there, 0 lost" in bridge.communicate(timeout=LONG_S)[1]


def test_a_kernel_without_can_says_so(bench: Bench) -> None:
    if has_can():
        pytest.skip("this kernel has CAN")
    command = [sys.executable, "-m", "canwire", "bridge", "--hub", bench.address, "can0", "vcan0"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2
    assert "this kernel has no CAN" in done.stderr


@pytest.mark.conforms("PL-12")
def test_with_the_kernel_s_own_vcan0(bench: Bench) -> None:
    if not has_can() or not os.path.exists("/sys/class/net/vcan0"):
        pytest.skip("this kernel has no vcan0")
    bridge = bench._started(["bridge", "can0", "vcan0"], {})
    assert bridge.stderr is not None
    assert "are one bus now" in bridge.stderr.readline()
    dump = bench.dump("can0", "-l", "-n", "1")
    subprocess.run(["cansend", "vcan0", "123#11"], check=True)
    assert frames(finished(dump)) == ["123#11"]
    bridge.send_signal(signal.SIGINT)


def has_can() -> bool:
    try:
        socket.socket(29, socket.SOCK_RAW, 1).close()
    except OSError:
        return False
    return True
