"""Programs in C on libcandrv and libacan, each compiled once for a run, on a hub in this process."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from canwire.native import include_directory, library_directory
from tests.hubs import LONG_S, served_here
from tests.missing import find_program

PROGRAMS = Path(__file__).parent / "programs"
CONFIG = '[[bus]]\nname = "can0"\n' + "".join(
    f'[[board]]\nkind = "{kind}"\nserial = "{serial}"\n'
    for kind, serial in (("netdcu", "HW000001"), ("netdcu", "HW000002"), ("inducan104", "HW000104"))
)
REGISTRY = "".join(
    f'[candrv.CID{number}]\nBoard = "HW00000{number}"\nEventQueueSize = 4000\n' for number in (1, 2)
)
Build = Callable[..., Path]


@pytest.fixture(scope="session")
def build(tmp_path_factory: pytest.TempPathFactory) -> Build:
    """A program of a source and of these libraries."""
    home = tmp_path_factory.mktemp("programs")

    def build(source: Path, *libraries: str) -> Path:
        made = home / source.stem
        if not made.exists():
            lib, include = library_directory(), include_directory()
            command = [find_program("gcc"), "-std=gnu11", "-O1", "-g", "-w", f"-I{include}", f"-I{PROGRAMS}"]
            command += [str(source), "-o", str(made), f"-L{lib}", f"-Wl,-rpath,{lib}"]
            subprocess.run([*command, *(f"-l{name}" for name in libraries), "-lcanwire"], check=True)
        return made

    return build


class Machine:
    """A hub, and how programs are run on it; `home` is their working directory."""

    def __init__(self, home: Path, address: str) -> None:
        self.home, self.address = home, address
        self._settings = {
            **os.environ,
            "CANWIRE_HUB": address,
            "CANWIRE_CONFIG": str(home / "registry.toml"),
            "CANWIRE_PYTHON": sys.executable,
        }
        self._started: list[subprocess.Popen[str]] = []

    def start(self, program: Path, *words: str) -> subprocess.Popen[str]:
        pipe = subprocess.PIPE
        command = ["stdbuf", "-oL", str(program), *words]
        process = subprocess.Popen(
            command, cwd=self.home, env=self._settings, stdin=pipe, stdout=pipe, stderr=pipe, text=True
        )
        self._started.append(process)
        return process

    def run(self, program: Path, *words: str) -> str:
        """What it prints; it has to succeed."""
        process = self.start(program, *words)
        out, errors = process.communicate(timeout=LONG_S)
        assert process.returncode == 0, out + errors
        return out

    def close(self) -> None:
        for process in self._started:
            process.kill()
            process.communicate()


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Machine]:
    (tmp_path / "registry.toml").write_text(REGISTRY)
    monkeypatch.setenv("CANWIRE_CONFIG", str(tmp_path / "registry.toml"))
    with served_here(tmp_path, CONFIG, time="real") as address:
        made = Machine(tmp_path, address)
        yield made
        made.close()
