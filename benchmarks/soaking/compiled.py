"""Programs of the soak in C and in C#, compiled once for a run."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from canwire.native import dotnet, include_directory, library_directory

_HERE = Path(__file__).parent
COMPILERS = {"c": "gcc", "c#": "mcs"}


def available() -> list[str]:
    """Kinds that this machine has a compiler for."""
    return [kind for kind, compiler in COMPILERS.items() if shutil.which(compiler)]


def compiled(kind: str, home: Path) -> list[str]:
    """The words that start the program of this kind, which is in `home` from then on."""
    return _in_c(home) if kind == "c" else _in_c_sharp(home)


def _in_c(home: Path) -> list[str]:
    made, lib = home / "keeper", library_directory()
    if not made.exists():
        words = ["gcc", "-O1", f"-I{include_directory()}", str(_HERE / "keeper.c"), "-o", str(made)]
        libraries = [f"-L{lib}", f"-Wl,-rpath,{lib}", "-lvcinpl2", "-lvciapi", "-lcanwire"]
        subprocess.run([*words, *libraries], check=True)
    return [str(made)]


def _in_c_sharp(home: Path) -> list[str]:
    made = home / "Keeper.exe"
    os.environ.setdefault("XDG_STATE_HOME", str(home))
    assemblies = dotnet.assembly_directory()
    os.environ["MONO_PATH"] = assemblies
    if not made.exists():
        references = [f"-r:{os.path.join(assemblies, name)}" for name in dotnet.NAMES]
        subprocess.run(["mcs", f"-out:{made}", *references, str(_HERE / "Keeper.cs")], check=True)
    return ["mono", str(made)]
