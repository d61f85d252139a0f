"""Programs in C and C++, each compiled once for a run, and hubs for them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from canwire.native import include_directory, library_directory
from tests.hubs import LONG_S, Served, serving
from tests.missing import find_program, supported

PROGRAMS = Path(__file__).parent / "programs"
Build = Callable[..., Path]


class Native:
    """Builds programs, and runs them on a hub."""

    def __init__(self, home: Path) -> None:
        self.home = home
        self._built: dict[tuple[str, ...], Path] = {}

    def build(self, source: str, *libraries: str, options: tuple[str, ...] = ()) -> Path:
        """The program of this source in programs/, linked with these libraries of canwire's."""
        wanted = (source, *libraries, *options)
        if wanted not in self._built:
            self._built[wanted] = self._compiled(source, libraries, options)
        return self._built[wanted]

    def _compiled(self, source: str, libraries: tuple[str, ...], options: tuple[str, ...]) -> Path:
        compiler = find_program("g++" if source.endswith(".cpp") else "gcc")
        made = self.home / f"{Path(source).stem}{len(self._built)}"
        lib = (
            os.environ.get("CANWIRE_TEST_LIBRARIES") or library_directory()
        )  # .ci/native_sanitizers has others
        options += tuple(os.environ.get("CANWIRE_TEST_OPTIONS", "").split())
        ended = subprocess.run(
            [compiler, "-O1", "-Wall", *options, f"-I{include_directory()}", f"-I{self.home}", str(self.home / source),
             "-o", str(made), f"-L{lib}", f"-Wl,-rpath,{lib}", *(f"-l{name}" for name in libraries), "-lcanwire"],
            capture_output=True, text=True,
        )  # fmt: skip
        assert ended.returncode == 0, ended.stderr
        return made

    def start(self, program: Path, hub: str) -> subprocess.Popen[str]:
        settings = {**os.environ, "CANWIRE_HUB": hub, "CANWIRE_PYTHON": sys.executable}
        pipe = subprocess.PIPE
        return subprocess.Popen([str(program)], env=settings, stdin=pipe, stdout=pipe, stderr=pipe, text=True)

    def run(self, program: Path, hub: str = "/nonexistent") -> str:
        """What it prints; it has to succeed."""
        with self.start(program, hub) as process:
            out, errors = process.communicate(timeout=LONG_S)
        assert process.returncode == 0, out + errors
        return out


@pytest.fixture(scope="session")
def native(tmp_path_factory: pytest.TempPathFactory) -> Native:
    if sys.platform != "linux":
        pytest.skip("the libraries for C are Linux's")
    supported(library_directory)
    home = tmp_path_factory.mktemp("programs")
    for source in PROGRAMS.iterdir():
        if source.name.startswith("manual_"):  # its lines of a dot alone stand for the reader's own code
            lines = source.read_text("utf-8").splitlines()
            (home / source.name).write_text("\n".join(line for line in lines if line.strip() != "."), "utf-8")
        else:
            shutil.copy(source, home)
    return Native(home)


@pytest.fixture
def hub(tmp_path: Path) -> Iterator[Served]:
    """With the usual boards, in real time."""
    with serving(tmp_path, time="real") as served:
        yield served
