"""The libraries of VCI for Windows, programs that use them, and hubs of Linux for these."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from canwire.native import include_directory
from tests.missing import find_program
from tests.windows.conftest import LONG_S, PYTHON

ROOT = Path(__file__).parents[2]
PROGRAMS = Path(__file__).parent / "programs"
NATIVE_PROGRAMS = ROOT / "tests" / "native" / "programs"

MADE = Path(PYTHON).parent / "dlls"  # where .ci/windows has everything else that it makes

Program = subprocess.Popen[str]


def _up_to_date() -> bool:
    """They are newer than all that they are made of."""
    native = ROOT / "src" / "canwire" / "native"
    sources = [path for kind in ("*.c", "*.cpp", "*.h") for path in native.rglob(kind)]
    library = MADE / "vciapi.dll"  # the last one that is made
    return library.exists() and library.stat().st_mtime > max(path.stat().st_mtime for path in sources)


class Libraries:
    """They are in `home`, and programs are built beside them, as on Windows."""

    def __init__(self, home: Path) -> None:
        self.home = home
        find_program("x86_64-w64-mingw32-g++")
        if not _up_to_date():
            subprocess.run(["bash", ROOT / ".ci" / "dlls", MADE], check=True, timeout=10 * LONG_S)
        for file in MADE.iterdir():
            shutil.copy(file, home)

    def build(self, source: Path, library: str, *options: str) -> Path:
        """The program of this source."""
        made = self.home / f"{source.stem}-{library}.exe"
        if not made.exists():
            compiler = "x86_64-w64-mingw32-" + ("g++" if source.suffix == ".cpp" else "gcc")
            command = [
                compiler,
                "-O1",
                *options,
                "-idirafter",
                include_directory(),
                str(source),
                "-o",
                str(made),
            ]
            link = [f"-L{self.home}", f"-l{library}", "-luuid", "-static-libgcc", "-static-libstdc++"]
            subprocess.run([*command, *link], check=True)
        return made


class Place:
    """A hub's address and how it is reached: settings for programs of Linux and Windows."""

    def __init__(self, address: str, platform: str = "", python: str = sys.executable) -> None:
        self.address = address
        prefix = os.environ.get("WINEPREFIX") or str(Path(PYTHON).parent / "prefix")
        self.settings = {
            **os.environ,
            "CANWIRE_HUB": address,
            "CANWIRE_PYTHON": python,
            "WINEPREFIX": prefix,
            "WINEDEBUG": "-all",
        }
        self.settings.pop("CANWIRE_PLATFORM", None)
        if platform:
            self.settings["CANWIRE_PLATFORM"] = platform

    @contextmanager
    def started(self, *command: str | Path) -> Iterator[Program]:
        """A process of it, which is killed in the end if it still runs."""
        pipe = subprocess.PIPE
        with subprocess.Popen(
            command, env=self.settings, stdin=pipe, stdout=pipe, stderr=subprocess.STDOUT, text=True
        ) as program:
            try:
                yield program
            finally:
                program.kill()

    def run(self, *command: str | Path) -> str:
        """What it prints; it has to succeed."""
        with self.started(*command) as program:
            said, _ = program.communicate(timeout=LONG_S)
        assert program.returncode == 0, said
        return said


@contextmanager
def serving_linux(home: Path, platform: str = "") -> Iterator[tuple[Place, Program]]:
    """A hub of Linux with the usual boards in real time, and its process."""
    place = Place(str(home / "hub"), platform)
    with place.started(
        sys.executable, "-m", "canwire", "serve", "--time", "real", "--socket", place.address
    ) as hub:
        wait_for(hub, "canwire hub on")
        yield place, hub


def wait_for(program: Program, holds: str) -> str:
    """The first line of its output with these words in it."""
    assert program.stdout is not None
    said = []
    for line in program.stdout:
        said.append(line)
        if holds in line:
            return line
    raise AssertionError(f"{program.args} ended without {holds!r}: {''.join(said)}")
