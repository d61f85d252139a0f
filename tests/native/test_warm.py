"""Warm helpers: a program after another one has its helper from a process that the first one's left behind."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

import canwire
from canwire.platform import wait_readable
from tests.hubs import LONG_S, Served, served_here
from tests.native.conftest import Native

DISCONNECTED = "E0010019\n"


class Started:
    """Starts programs that wait for a frame. `own` makes their warm helper another one than anybody else's."""

    def __init__(self, program: Path, own: str, stays: str) -> None:
        self._program = program
        self._variables = {"PYTHON_OF_THIS_TEST": own, "CANWIRE_HELPER_STAYS": stays}

    @contextmanager
    def program(self, hub: str, folder: Path) -> Iterator[subprocess.Popen[str]]:
        settings = {**os.environ, **self._variables, "CANWIRE_HUB": hub, "CANWIRE_PYTHON": sys.executable}
        pipe = subprocess.PIPE
        words = [str(self._program)]
        with subprocess.Popen(
            words, env=settings, cwd=folder, stdout=pipe, stderr=pipe, text=True
        ) as process:
            try:
                assert process.stdout is not None
                assert process.stdout.readline() == "waiting\n", process.communicate()
                yield process
            finally:
                process.kill()


def helper_at(hub: str) -> int:
    """The process that has the first line's control, as its hub sees it."""
    with canwire.connect(hub) as looking:
        (place,) = canwire.find_lines(looking, "HW000001:0")
        control = place.status(looking).control_holder
    assert control.startswith("waits")
    return int(control.partition("(")[2].partition(")")[0])


def parent_of(process: int) -> int:
    return int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])


def knock(warm: int) -> None:
    """Ask without a word, and with words that are none."""
    name = Path(f"/proc/{warm}/cmdline").read_bytes().rstrip(b"\0").rpartition(b"\0")[2]
    for said in (b"", b"no program"):
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as asking:
            asking.connect(b"\0" + name)
            if said:
                asking.send(said)


def ends(process: int) -> bool:
    """Before long."""
    try:
        ended = os.pidfd_open(process)
    except ProcessLookupError:
        return True
    try:
        return bool(wait_readable([ended], LONG_S))
    finally:
        os.close(ended)


@contextmanager
def killed_at_last(process: int) -> Iterator[int]:
    try:
        yield process
    finally:
        os.kill(process, signal.SIGKILL)
        assert ends(process)


@pytest.mark.conforms("N-45")
def test_programs_after_the_first_have_warm_helpers_of_their_own(
    native: Native, hub: Served, tmp_path: Path
) -> None:
    """Hub, folder and name are each program's own, and nothing is left of it."""
    start = Started(native.build("waits.cpp", "vciapi"), str(tmp_path), "600")
    (tmp_path / "other").mkdir()
    with ExitStack() as running:
        address = Path(running.enter_context(served_here(tmp_path / "other", time="real")))
        running.enter_context(start.program(hub.address, tmp_path))
        first = helper_at(hub.address)
        warm = running.enter_context(killed_at_last(parent_of(first)))
        knock(warm)
        with start.program(address.name, address.parent):
            second = helper_at(str(address))
            assert parent_of(second) == warm
        assert ends(second)
        running.pop_all().close()
        assert ends(first)


@pytest.mark.conforms("N-45")
def test_helpers_outlive_the_warm_process_which_ends_unused(
    native: Native, hub: Served, tmp_path: Path
) -> None:
    start = Started(native.build("waits.cpp", "vciapi"), str(tmp_path), "0.01")
    with start.program(hub.address, tmp_path) as process:
        helper = helper_at(hub.address)
        warm = parent_of(helper)
        assert not is_canwires(warm) or ends(warm)
        os.kill(helper, signal.SIGKILL)
        out, errors = process.communicate(timeout=LONG_S)
        assert (process.returncode, out) == (0, DISCONNECTED), errors


def is_canwires(process: int) -> bool:
    """It has not ended yet, which leaves its children to the system."""
    try:
        return b"canwire.native.helper" in Path(f"/proc/{process}/cmdline").read_bytes()
    except OSError:
        return False
