"""Hubs in processes of their own, and python-can programs that know nothing of this tree but the interface's name."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import can.interfaces
import pytest

import canwire
from canwire.python_can import CanwireBus
from tests import warm
from tests.cold import entry_points
from tests.hubs import Served, serving
from tests.python_can.programs import Open, Program

ROOT = Path(__file__).resolve().parent.parent.parent
INSTALLED = (
    "canwire" in can.interfaces.BACKENDS
)  # else a warm program, which has loaded python-can, does not find us


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    """A hub in real time for this test alone."""
    with serving(tmp_path, time="real") as made:
        yield made


@pytest.fixture
def open_bus(served: Served) -> Iterator[Open]:
    """Makes buses on that hub, all closed at the end."""
    made: list[CanwireBus] = []

    def open_one(channel: str = "can0", **arguments: object) -> CanwireBus:
        made.append(CanwireBus(channel, hub=served.address, **arguments))  # type: ignore[arg-type]
        return made[-1]

    yield open_one
    for bus in made:
        bus.shutdown()


@pytest.fixture
def hub() -> Iterator[canwire.Hub]:
    """A hub in this process whose time passes only while somebody waits."""
    with canwire.connect(time="virtual") as made:
        yield made


@pytest.fixture(scope="session")
def installed(tmp_path_factory: pytest.TempPathFactory) -> str:
    """What to put on PYTHONPATH so that python-can finds our entry point, as where canwire is installed."""
    home = entry_points(tmp_path_factory.mktemp("installed"))
    return os.pathsep.join(filter(None, [home, str(ROOT / "src"), os.environ.get("PYTHONPATH", "")]))


@pytest.fixture(scope="session")
def path(installed: str) -> str:
    """PYTHONPATH of python-can programs."""
    inside = Path(canwire.__file__).is_relative_to(ROOT)
    return installed if inside else installed.replace(str(ROOT / "src"), "")


@pytest.fixture
def program(served: Served, path: str) -> Iterator[Program]:
    """Starts an unmodified python-can program; it says "ready" first unless told otherwise.

    `cold`: it imports python-can and canwire itself.
    """
    started: list[subprocess.Popen[str]] = []

    def start(
        body: str, *, ready: bool = True, stderr: int | None = None, cold: bool = False
    ) -> subprocess.Popen[str]:
        process = (subprocess.Popen if cold or not INSTALLED else warm.Popen)(
            [sys.executable, "-c", body],
            text=True,
            env={**os.environ, "CANWIRE_HUB": served.address, "PYTHONPATH": path},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=stderr,
        )
        started.append(process)
        assert process.stdout is not None
        if ready:
            assert process.stdout.readline() == "ready\n"
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()
