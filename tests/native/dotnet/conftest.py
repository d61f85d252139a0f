"""Programs in C#, each compiled once for a run by Mono's compiler, on a hub."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from canwire.native import dotnet, library_directory
from tests.hubs import LONG_S
from tests.missing import find_program, supported

PROGRAMS = Path(__file__).parent / "programs"


class Mono:
    """Compiles programs into one directory and runs them; the assemblies are in the user's state."""

    def __init__(self, home: Path, state: Path, assemblies: str) -> None:
        self.home, self.state, self.assemblies = home, state, assemblies

    def build(self, source: Path, *others: Path, options: tuple[str, ...] = ()) -> Path:
        made = self.home / f"{source.stem}.exe"
        if not made.exists():
            references = [f"-r:{os.path.join(self.assemblies, name)}" for name in dotnet.NAMES]
            ended = subprocess.run(
                [find_program("mcs"), f"-out:{made}", *options, *references, str(source), *map(str, others)],
                capture_output=True,
                text=True,
            )
            assert ended.returncode == 0, ended.stdout + ended.stderr
        return made

    def program(self, name: str, *options: str) -> Path:
        """One of programs/, with what all of them use."""
        return self.build(PROGRAMS / name, PROGRAMS / "Boards.cs", options=options)

    def start(self, program: Path, hub: str) -> subprocess.Popen[str]:
        settings = {
            **os.environ,
            "CANWIRE_HUB": hub,
            "CANWIRE_PYTHON": sys.executable,
            "MONO_PATH": self.assemblies,
        }
        pipe = subprocess.PIPE
        return subprocess.Popen(
            [find_program("mono"), str(program)],
            env=settings,
            stdin=pipe,
            stdout=pipe,
            stderr=pipe,
            text=True,
        )

    def run(self, program: Path, hub: str) -> str:
        """What it prints; it has to succeed."""
        with self.start(program, hub) as process:
            out, errors = process.communicate(timeout=LONG_S)
        assert process.returncode == 0, out + errors
        return out


@pytest.fixture(scope="session")
def mono(tmp_path_factory: pytest.TempPathFactory) -> Mono:
    supported(library_directory)
    find_program("mcs")
    find_program("mono")
    from tests.native.dotnet.state import state_of_this_run  # where the libraries are, locks are, too

    state = state_of_this_run(tmp_path_factory)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(state))
        return Mono(tmp_path_factory.mktemp("dotnet"), state, dotnet.assembly_directory())
