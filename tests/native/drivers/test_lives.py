"""What CANDRV's and ACAN's programs hear when the hub or their helper ends, in forks and threads; after a kill."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

import canwire
from canwire import candrv
from canwire.platform import wait_readable
from tests.hubs import LONG_S, serving
from tests.native.drivers.conftest import CONFIG, PROGRAMS, REGISTRY, Build, Machine

pytestmark = pytest.mark.conforms("N-45")


@pytest.fixture
def program(build: Build) -> Path:
    """With both libraries."""
    return build(PROGRAMS / "lives.c", "candrv", "acan")


def test_the_hub_ends(program: Path, tmp_path: Path) -> None:
    (tmp_path / "registry.toml").write_text(REGISTRY)
    with serving(tmp_path, CONFIG, time="real") as (address, hub):
        machine = Machine(tmp_path, address)
        process = machine.start(program, "hub")
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n", process.communicate()
        hub.kill()
        hub.wait(LONG_S)
        assert process.communicate("\n", LONG_S) == ("done\n", "")


def test_the_helper_ends_and_the_next_call_has_another_one(program: Path, machine: Machine) -> None:
    process = machine.start(program, "helper")
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n", process.communicate()
    helper = helper_of(process.pid)
    ended = os.pidfd_open(helper)
    os.kill(helper, signal.SIGKILL)
    assert wait_readable([ended], LONG_S)
    os.close(ended)
    assert process.communicate("\n", LONG_S) == ("done\n", "")


@pytest.mark.parametrize("case", ["fork", "threads"])
def test_forks_and_threads(program: Path, machine: Machine, case: str) -> None:
    assert machine.run(program, case) == "done\n"


def test_a_killed_program_leaves_nothing(program: Path, machine: Machine) -> None:
    process = machine.start(program, "none")
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n", process.communicate()
    ended = os.pidfd_open(helper_of(process.pid))
    process.kill()
    assert wait_readable([ended], LONG_S)
    os.close(ended)
    with canwire.connect(machine.address) as hub, candrv.open("CID1:", hub=hub, share=0) as handle:
        assert handle.readable


def helper_of(program: int) -> int:
    """The process that works for this one, as its command line says."""
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = path.read_bytes().split(b"\0")
        except OSError:  # it has ended meanwhile
            continue
        if b"canwire.native.helper.main" in b" ".join(words) and str(program).encode() in words:
            return int(path.parent.name)
    raise AssertionError(f"process {program} has no helper")
