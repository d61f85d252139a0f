"""499 points of the system-call interface: what a program is answered here and by a kernel with vcan.

kernel/points.c is the examiners' program (shared/reference/socketcan-kernel/fidelity.c with the one write of 8301 bytes
that its recorded run had besides), kernel/answers-6.1.txt what Linux 6.1.192 answered with vcan0 and vcan1. With
CANWIRE_VCAN=1, where these two interfaces are up, the same program runs on this machine's kernel as well.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.hubs import LONG_S, serving
from tests.missing import find_program
from tests.socketcan.bench import Bench, Process

HERE = Path(__file__).parent / "kernel"
BUSES = (Path(__file__).parent.parent.parent / "examples" / "two-buses.toml").read_text()
ANSWERS = (HERE / "answers-6.1.txt").read_text().splitlines()
NAMES = ("--interface", "vcan0=can0", "--interface", "vcan1=can1")

# each with its reason in docs/socketcan.md, "Where the answers differ"
OURS = {
    "read.TIMESTAMPING.hw": "16 flags 4 name 8 ctl 64: type37 len64(001)",
}
IN_HUB_TIME = ("socket", "bind", "options", "ioctl", "write", "read", "loop", "bcm", "isotp", "overflow")
IN_FAST_TIME = (
    "poll",
    "fds",
    "efaultw",
    "efaultr",
    "efaulto",
    "efaulti",
    "errqueue",
    "errqueue2",
)


def expected(section: str) -> list[str]:
    """Our answers: the kernel's but for OURS."""
    of_kernel = [line.split(": ", 1) for line in ANSWERS if line.startswith(f"{section}.")]
    return [f"{name}: {OURS.get(name, answer)}" for name, answer in of_kernel]


@pytest.fixture(scope="module")
def points(tmp_path_factory: pytest.TempPathFactory) -> str:
    find_program("gcc")
    made = tmp_path_factory.mktemp("points") / "points"
    source = str(HERE / "points.c")
    subprocess.run(["gcc", "-O1", "-w", "-pthread", source, "-o", str(made)], check=True)
    return str(made)


@pytest.fixture(scope="module")
def begun(points: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Process]]:
    """Sections that wait by the wall's clock for most of their time, all of them at the same time."""
    with ExitStack() as closing:
        started = {}
        for section in IN_FAST_TIME:
            home = tmp_path_factory.mktemp(section)
            bench = Bench(closing.enter_context(serving(home, BUSES)), home)
            closing.callback(bench.close)
            started[section] = bench.start(points, section, options=NAMES)
        yield started


def test_every_point_is_asked_for() -> None:
    assert {line.split(".", 1)[0] for line in ANSWERS} == {*IN_HUB_TIME, *IN_FAST_TIME}
    assert len(ANSWERS) == 499


@pytest.mark.conforms("N-21", "N-22", "N-23", "N-24", "N-25", "N-26", "N-27", "N-52")
@pytest.mark.finding("socketcan 10", "socketcan 11", "socketcan 16")
@pytest.mark.parametrize("section", IN_HUB_TIME)
def test_points_in_hub_time(points: str, tmp_path: Path, section: str) -> None:
    """By the hub's time alone, which passes as quickly as the program asks."""
    with serving(tmp_path, BUSES, time="lockstep") as served:
        bench = Bench(served, tmp_path)
        try:
            environment = {**os.environ, "CANWIRE_HUB": served.address, "CANWIRE_TIMED": "1"}
            process = bench.start(points, section, options=NAMES, env=environment)
            output, _ = process.communicate(timeout=LONG_S)
        finally:
            bench.close()
    assert output.splitlines() == expected(section)


@pytest.mark.conforms("N-21", "N-26", "N-27")
@pytest.mark.finding("socketcan 10", "socketcan 11", "socketcan 12", "socketcan 16")
@pytest.mark.parametrize("section", IN_FAST_TIME)
def test_points_by_the_clock(begun: dict[str, Process], section: str) -> None:
    output, _ = begun[section].communicate(timeout=LONG_S)
    assert output.splitlines() == expected(section)


@pytest.mark.skipif(
    os.environ.get("CANWIRE_VCAN") != "1", reason="CANWIRE_VCAN=1: this kernel has vcan0 and vcan1"
)
def test_points_of_this_kernel(points: str) -> None:
    """Kernels after 6.1 may differ: then this table is theirs to extend."""
    found = subprocess.run([points], capture_output=True, text=True, check=True, timeout=3 * LONG_S)
    assert found.stdout.splitlines() == ANSWERS
