"""Programs that preload nothing: the server answers their calls."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from canwire.socketcan.programs import calls_itself
from tests.missing import find_program
from tests.socketcan.bench import Bench, finished

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def static(tmp_path_factory: pytest.TempPathFactory) -> str:
    find_program("gcc")
    made = tmp_path_factory.mktemp("static") / "dump"
    subprocess.run(["gcc", "-std=gnu11", "-O2", "-static", str(HERE / "dump.c"), "-o", str(made)], check=True)
    return str(made)


@pytest.mark.conforms("N-48")
@pytest.mark.finding("socketcan 7")
@pytest.mark.parametrize("before", [(), ("sh", "-c", 'exec "$0"'), ("timeout", "60")])
def test_a_static_program_has_the_interfaces(bench: Bench, static: str, before: tuple[str, ...]) -> None:
    """By itself, from a shell, and by execvp: its name and time come with a frame, and it sends by every way."""
    find_program("cansend")
    others = bench.listening("candump", "can0")
    program = bench.start(*before, static)
    assert others.stdout is not None
    assert others.stdout.readline() == "  can0  100   [1]  00\n"
    bench.run("cansend", "can0", "124#55")  # which its filter does not let pass
    bench.run("cansend", "can0", "123#1122")
    bench.run("cansend", "can0", "123#33")
    output, errors = program.communicate(timeout=30)
    assert (program.returncode, output, errors) == (0, "can0 123 [2] 1\n", "")


def test_a_static_program_starts_dynamic_ones(bench: Bench) -> None:
    """The shim works under the filter, too."""
    busybox = find_program("busybox")
    if not calls_itself(busybox):
        pytest.skip("this busybox is linked dynamically")
    dump = bench.listening("candump", "can0", "-n", "1")
    bench.run(busybox, "sh", "-c", "cansend can0 123#7F")
    assert finished(dump) == "  can0  123   [1]  7F\n"
