"""A program in C: its descriptors are the kernel's own, and its mistakes have the kernel's answers."""

from __future__ import annotations

import resource
import subprocess
from pathlib import Path

import pytest

from tests.missing import find_program
from tests.socketcan.bench import Bench

HERE = Path(__file__).parent


def compiled(name: str, factory: pytest.TempPathFactory) -> str:
    find_program("gcc")
    made = factory.mktemp(name) / name
    subprocess.run(["gcc", "-std=gnu11", "-O2", str(HERE / f"{name}.c"), "-o", str(made)], check=True)
    return str(made)


@pytest.fixture(scope="session")
def program(tmp_path_factory: pytest.TempPathFactory) -> str:
    return compiled("program", tmp_path_factory)


@pytest.fixture(scope="session")
def as_kernel(tmp_path_factory: pytest.TempPathFactory) -> str:
    return compiled("as_kernel", tmp_path_factory)


@pytest.mark.conforms("PL-12", "N-22", "N-23", "N-27")
@pytest.mark.parametrize(
    "what", ["names", "mistakes", "descriptors", "exec", "own", "overflow", "full", "stamps", "storm"]
)
def test_sockets(bench: Bench, program: str, what: str) -> None:
    assert bench.run(program, what).endswith("done\n")


@pytest.mark.finding("socketcan 2", "socketcan 3", "socketcan 4", "socketcan 6", "socketcan 13")
@pytest.mark.parametrize("what", ["unbound", "remote", "restart", "pointers", "bcm"])
def test_answers_of_a_kernel(bench: Bench, as_kernel: str, what: str) -> None:
    assert bench.run(as_kernel, what) == "done\n"


@pytest.mark.finding("socketcan 16")
def test_an_error_frame_that_is_sent_is_counted(bench: Bench, as_kernel: str) -> None:
    process = bench.start(as_kernel, "errors")
    _, errors = process.communicate(timeout=30)
    assert "can0: 1 frames were dropped, no frames that a controller can send (CAN_ERR_FLAG)" in errors


def test_thousands_of_sockets(bench: Bench, program: str) -> None:
    if resource.getrlimit(resource.RLIMIT_NOFILE)[1] < 4096:
        pytest.skip("this process may have fewer descriptors")
    assert bench.run("sh", "-c", f"ulimit -n 4096; {program} thousands").endswith("done\n")


def test_what_is_not_there_is_said_once(bench: Bench, program: str) -> None:
    process = bench.start(program, "mistakes")
    _, errors = process.communicate(timeout=30)
    assert errors.count("asked for CAN protocol 5, which there is not here") == 1


def test_a_hub_that_goes_is_a_network_that_is_down(bench: Bench) -> None:
    dump = bench.listening("candump", "can0")
    bench.run("cansend", "can0", "123#")
    assert dump.stdout is not None
    assert dump.stdout.readline() == "  can0  123   [0] \n"
    bench.stop_hub()
    _, errors = dump.communicate(timeout=30)
    assert dump.returncode == 1
    assert "Network is down" in errors


def test_signals_are_as_a_program_finds_them_otherwise(bench: Bench) -> None:
    """Python ignores SIGPIPE and SIGXFSZ, and what is ignored stays so in whatever it becomes."""
    assert bench.run("grep", "SigIgn", "/proc/self/status").split()[1] == "0" * 16
