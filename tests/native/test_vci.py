"""VCI V4 in C++ and the flat interface, by programs on a hub."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from canwire.platform import wait_readable
from tests.hubs import LONG_S, Served
from tests.native.conftest import Native


@pytest.mark.conforms("N-39")
def test_the_manuals_listings_compile_as_printed_and_run(native: Native, hub: Served) -> None:
    assert "did what they say" in native.run(native.build("manual.cpp", "vciapi"), hub.address)


@pytest.mark.conforms("N-39", "N-45")
def test_every_mistake_has_the_vendors_code(native: Native, hub: Served) -> None:
    assert "has its code" in native.run(native.build("errors.cpp", "vciapi"), hub.address)


@pytest.mark.conforms("N-46")
def test_frames_keep_their_order_and_losses_are_told(native: Native, hub: Served) -> None:
    assert "2500 in order" in native.run(native.build("stream.cpp", "vciapi"), hub.address)


@pytest.mark.conforms("N-40")
@pytest.mark.parametrize(("library", "options"), [("vcinpl", ()), ("vcinpl2", ("-DFD",))])
def test_the_flat_interface(native: Native, hub: Served, library: str, options: tuple[str, ...]) -> None:
    program = native.build("flat.c", library, "vciapi", options=options)
    assert "flat interface" in native.run(program, hub.address)


def test_windows_functions_without_any_hub(native: Native) -> None:
    assert "Windows' functions" in native.run(native.build("windows.c"))


@contextmanager
def waiting(native: Native, hub: Served) -> Iterator[subprocess.Popen[str]]:
    """A program that waits for a frame; it ends with the test, also with one that fails."""
    with native.start(native.build("waits.cpp", "vciapi"), hub.address) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "waiting\n"
            yield process
        finally:
            process.kill()


def helper_of(process: subprocess.Popen[str]) -> int:
    """The one process whose command line names this program as the one that it works for."""
    found = [
        int(path.parent.name)
        for path in Path("/proc").glob("[0-9]*/cmdline")
        if f"\0{process.pid}\0".encode() in _content(path) and b"canwire.native.helper" in _content(path)
    ]
    assert len(found) == 1
    return found[0]


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:  # it has ended meanwhile
        return b""


@pytest.mark.conforms("N-45")
def test_who_waits_hears_of_the_hubs_end(native: Native, hub: Served) -> None:
    with waiting(native, hub) as process:
        hub.process.kill()
        out, errors = process.communicate(timeout=LONG_S)
        assert (process.returncode, out) == (0, "E0010019\n"), errors  # VCI_E_DISCONNECTED


@pytest.mark.conforms("N-45")
def test_who_waits_hears_of_the_helpers_end(native: Native, hub: Served) -> None:
    with waiting(native, hub) as process:
        os.kill(helper_of(process), signal.SIGKILL)
        out, errors = process.communicate(timeout=LONG_S)
        assert (process.returncode, out) == (0, "E0010019\n"), errors


@pytest.mark.conforms("N-45")
def test_a_killed_program_leaves_nothing(native: Native, hub: Served) -> None:
    with waiting(native, hub) as process:
        helper = os.pidfd_open(helper_of(process))
        try:
            process.kill()
            assert wait_readable([helper], LONG_S)
        finally:
            os.close(helper)
    assert "every mistake" in native.run(
        native.build("errors.cpp", "vciapi"), hub.address
    )  # the line is free again
