"""Programs for Windows in C and C++, and python-can's own interface for IXXAT, on the libraries of VCI, by Wine."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from canwire.platform import wait_readable
from tests.missing import find_program
from tests.windows.conftest import LONG_S, PYTHON, Windows
from tests.windows.libraries import (
    NATIVE_PROGRAMS,
    PROGRAMS,
    Libraries,
    Place,
    Program,
    serving_linux,
    wait_for,
)

CANWIRE = (sys.executable, "-m", "canwire")


@pytest.fixture(scope="session")
def libraries(tmp_path_factory: pytest.TempPathFactory) -> Libraries:
    if not PYTHON:
        pytest.skip("here is no Python of Windows: bash .ci/windows makes one, and runs these tests")
    return Libraries(tmp_path_factory.mktemp("libraries"))


@pytest.mark.conforms("N-44")
@pytest.mark.parametrize("platform", ["portable", ""])
def test_a_program_in_c_on_a_hub_of_linux(libraries: Libraries, tmp_path: Path, platform: str) -> None:
    one = libraries.build(NATIVE_PROGRAMS / "flat.c", "vcinpl", "-w")
    other = libraries.build(NATIVE_PROGRAMS / "flat.c", "vcinpl2", "-w", "-DFD")
    with serving_linux(tmp_path, platform) as (place, _):
        assert "flat interface" in place.run("wine", one)
        assert "flat interface" in place.run("wine", other)


@pytest.mark.conforms("N-44", "N-45", "N-46")
def test_a_program_in_cpp_on_a_hub_of_linux(libraries: Libraries, tmp_path: Path) -> None:
    stream = libraries.build(NATIVE_PROGRAMS / "stream.cpp", "vciapi", "-w")
    errors = libraries.build(NATIVE_PROGRAMS / "errors.cpp", "vciapi", "-w")
    with serving_linux(tmp_path, "portable") as (place, _):
        assert "2500 in order" in place.run("wine", stream)
        assert "has its code" in place.run("wine", errors)


@pytest.mark.conforms("N-44")
def test_all_of_it_on_windows(libraries: Libraries, windows: Windows, tmp_path: Path) -> None:
    """As a user of Windows has it: hub, helper and program are processes of Windows."""
    stream = libraries.build(NATIVE_PROGRAMS / "stream.cpp", "vciapi", "-w")
    errors = libraries.build(NATIVE_PROGRAMS / "errors.cpp", "vciapi", "-w")
    address = windows.path(tmp_path / "hub")
    wait_for(windows.start("-m", "canwire", "serve", "--time", "real", "--socket", address), "canwire hub on")
    python = windows.run("-c", "import sys; print(sys.executable)").strip()
    place = Place(address, python=python)
    assert "2500 in order" in place.run("wine", stream)
    assert "has its code" in place.run("wine", errors)


def helper_of(program: Path) -> int:
    """The one process of Linux that answers for this program of Windows."""
    found = [
        int(path.parent.name)
        for path in Path("/proc").glob("[0-9]*/cmdline")
        if f"\0{program.name}\0".encode() in (said := _content(path)) and b"canwire.native.helper" in said
    ]
    assert len(found) == 1
    return found[0]


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:  # it has ended meanwhile
        return b""


@pytest.mark.conforms("N-45")
@pytest.mark.parametrize("who", ["hub", "helper"])
def test_who_waits_hears_of_an_end(libraries: Libraries, tmp_path: Path, who: str) -> None:
    waits = libraries.build(NATIVE_PROGRAMS / "waits.cpp", "vciapi", "-w")
    with serving_linux(tmp_path, "portable") as (place, hub), place.started("wine", waits) as program:
        wait_for(program, "waiting")
        os.kill(hub.pid if who == "hub" else helper_of(waits), signal.SIGKILL)
        said, _ = program.communicate(timeout=LONG_S)
        assert (program.returncode, said) == (0, "E0010019\n")  # VCI_E_DISCONNECTED


@pytest.mark.conforms("N-45")
def test_a_killed_program_leaves_nothing(libraries: Libraries, tmp_path: Path) -> None:
    waits = libraries.build(NATIVE_PROGRAMS / "waits.cpp", "vciapi", "-w")
    with serving_linux(tmp_path, "portable") as (place, _), place.started("wine", waits) as program:
        wait_for(program, "waiting")
        helper = os.pidfd_open(helper_of(waits))
        try:
            program.kill()
            assert wait_readable([helper], LONG_S)
        finally:
            os.close(helper)


@pytest.mark.conforms("N-44")
def test_everybody_is_on_one_bus(libraries: Libraries, windows: Windows, tmp_path: Path) -> None:
    """VCI in C++, python-can's `ixxat` and `canwire dump` on Windows; candump, `canwire dump` and `send` on Linux."""
    find_program("candump")
    program = libraries.build(PROGRAMS / "bus.cpp", "vciapi", "-Wall", "-Werror")
    with serving_linux(tmp_path, "portable") as (place, _), ExitStack() as running:

        def started(*command: str | Path) -> Program:
            return running.enter_context(place.started(*command))

        cpp = started("wine", program)
        python_can = started(PYTHON, windows.path(PROGRAMS / "ixxat.py"), windows.path(libraries.home))
        for sender in (cpp, python_can):
            wait_for(sender, "sending")  # else others would set their lines up in other ways
        dump = started(*CANWIRE, "dump", "HW000001:0")
        candump = started(*CANWIRE, "run", "--", "candump", "any")
        there = started(PYTHON, "-m", "canwire", "dump", "HW000002:0")
        for listener in (dump, candump, there):
            for identifier in ("123", "321"):
                wait_for(listener, f" {identifier} ")
        place.run(*CANWIRE, "send", "HW000003:0", "456#01")
        wait_for(cpp, "heard 123 and 456")
        wait_for(python_can, "heard 321 and 456")
        for listener in (dump, candump, there):
            wait_for(listener, " 456 ")
        for ending in (cpp, python_can):
            said, _ = ending.communicate(timeout=LONG_S)
            assert ending.returncode == 0, said
