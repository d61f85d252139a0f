"""Programs that preload nothing: the server answers their calls."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from canwire.socketcan.programs import calls_itself
from tests.missing import find_program
from tests.socketcan.bench import Bench, finished

HERE = Path(__file__).parent


def built(factory: pytest.TempPathFactory, compiler: str, *switches: str, source: str = "dump.c") -> str:
    """By this compiler."""
    find_program(compiler)
    made = factory.mktemp("built") / "dump"
    subprocess.run(
        [compiler, "-std=gnu11", "-O2", *switches, str(HERE / source), "-o", str(made)], check=True
    )
    return str(made)


@pytest.fixture(scope="module")
def static(tmp_path_factory: pytest.TempPathFactory) -> str:
    return built(tmp_path_factory, "gcc", "-static")


def kernel_headers(folder: Path) -> str:
    """Those of Linux without the C library's, for musl's compiler."""
    usual = Path("/usr/include")
    for name in ("linux", "asm-generic"):
        (folder / name).symlink_to(usual / name)
    (folder / "asm").symlink_to(next(usual.glob("*-linux-gnu/asm"), usual / "asm"))
    return str(folder)


def exchange(bench: Bench, *words: str) -> None:
    """The program sends 100#00, hears two frames of ours, and says what it heard first."""
    others = bench.listening("candump", "can0")
    program = bench.start(*words)
    assert others.stdout is not None
    assert others.stdout.readline() == "  can0  100   [1]  00\n"
    bench.run("cansend", "can0", "124#55")  # which its filter does not let pass
    bench.run("cansend", "can0", "123#1122")
    bench.run("cansend", "can0", "123#33")
    output, errors = program.communicate(timeout=30)
    assert (program.returncode, output, errors) == (0, "can0 123 [2] 1\n", "")


@pytest.mark.conforms("N-48")
@pytest.mark.finding("socketcan 7")
@pytest.mark.parametrize("before", [(), ("sh", "-c", 'exec "$0"'), ("timeout", "60")])
def test_a_static_program_has_the_interfaces(bench: Bench, static: str, before: tuple[str, ...]) -> None:
    """By itself, from a shell, and by execvp: its name and time come with a frame, and it sends by every way."""
    find_program("cansend")
    exchange(bench, *before, static)


@pytest.mark.conforms("N-48")
@pytest.mark.parametrize("switches", [(), ("-static",)], ids=["dynamic", "static"])
def test_a_program_of_musl_has_them(
    bench: Bench, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, switches: tuple[str, ...]
) -> None:
    """By itself, and from a shell, whose LD_PRELOAD its loader could not take."""
    find_program("cansend")
    made = built(tmp_path_factory, "musl-gcc", *switches, "-isystem", kernel_headers(tmp_path))
    exchange(bench, made)
    exchange(bench, "sh", "-c", f"{made}")


@pytest.mark.conforms("N-48")
@pytest.mark.parametrize("cgo", ["0", "1"])
def test_a_go_program_has_them(bench: Bench, tmp_path: Path, cgo: str) -> None:
    """With its own resolver of names, by netlink, and with the C library linked in."""
    made = tmp_path / "frames"
    environment = {
        **os.environ,
        "CGO_ENABLED": cgo,
        "GOCACHE": str(tmp_path / "cache"),
        "GOFLAGS": "-mod=mod",
    }
    source = str(HERE / "frames.go")
    subprocess.run([find_program("go"), "build", "-o", str(made), source], check=True, env=environment)
    dump = bench.listening("candump", "can0", "-n", "1")
    program = bench.start(str(made))
    assert finished(dump) == "  can0  123   [2]  47 6F\n"
    bench.run("cansend", "can0", "321#33")
    output, errors = program.communicate(timeout=30)
    assert (program.returncode, output, errors) == (0, "can0 1001 72: 321 33\n", "")


@pytest.mark.conforms("N-48", "N-49")
def test_a_static_program_has_j1939(bench: Bench, tmp_path_factory: pytest.TempPathFactory) -> None:
    """A message of several frames, its sender's address and PGN, and as control messages destination and priority."""
    made = built(tmp_path_factory, "gcc", "-static", source="j1939.c")
    assert bench.run(made) == "3006\n"


def test_a_static_program_starts_dynamic_ones(bench: Bench) -> None:
    """The shim works under the filter, too."""
    busybox = find_program("busybox")
    if not calls_itself(busybox):
        pytest.skip("this busybox is linked dynamically")
    dump = bench.listening("candump", "can0", "-n", "1")
    bench.run(busybox, "sh", "-c", "cansend can0 123#7F")
    assert finished(dump) == "  can0  123   [1]  7F\n"


MANY = """\
sent 4 of 16 bytes, heard 4 of 16: 1 2 3 4, address 1
then -1, errno 11
{ring}
stamped 5, 96 bytes of control, flags 2000
"""


@pytest.mark.conforms("N-48", "N-52")
@pytest.mark.finding("socketcan 6", "socketcan 10")
@pytest.mark.parametrize("switches", [(), ("-static",)], ids=["served by the library", "static"])
def test_many_messages_in_one_call(
    bench: Bench, tmp_path_factory: pytest.TempPathFactory, switches: tuple[str, ...]
) -> None:
    """Also by io_uring, where this kernel lets programs have that: its writes and reads are frames, too."""
    made = built(tmp_path_factory, "gcc", *switches, source="many.c")
    found = bench.run(made)
    ring = "ring: 2 done, heard 77 of 2 bytes"
    forbidden = next(
        (line for line in found.splitlines() if line in ("ring: 1", "ring: 38")), ring
    )  # EPERM, ENOSYS
    assert found == MANY.format(ring=forbidden)
