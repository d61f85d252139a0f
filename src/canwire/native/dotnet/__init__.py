"""The assemblies Ixxat.Vci4 and Ixxat.Vci3 for programs in .NET: their sources, and their compilation on demand.

contract/ has the public interfaces, classes/ their implementation, core/ the calls of libvciapi. docs/native.md is for
users.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from canwire import Unsupported, state_directory
from canwire.native import library_directory

_HERE = Path(__file__).resolve().parent
_COMPILERS = ("mcs", "csc")  # Mono's; both take the same options
_SHARED = ("core", "classes", "classes/can", "classes/lin")
_CONTRACT = ("contract", "contract/can", "contract/lin")


@dataclass(frozen=True)
class _Assembly:
    """What an assembly is compiled from: subfolders of this folder, and other assemblies."""

    name: str
    version: str
    folders: tuple[str, ...]
    options: tuple[str, ...] = ()
    references: tuple[str, ...] = ()


_ASSEMBLIES = (
    _Assembly("Ixxat.Vci4.Contract", "4.1.13.0", (*_CONTRACT, "contract/v4")),
    _Assembly("Ixxat.Vci4", "4.1.13.0", (*_SHARED, "classes/v4"), references=("Ixxat.Vci4.Contract",)),
    _Assembly("Ixxat.Vci3", "3.5.0.0", (*_CONTRACT, *_SHARED, "classes/v3"), options=("-define:VCI3",)),
)
NAMES = tuple(f"{one.name}.dll" for one in _ASSEMBLIES)


def source_directory() -> str:
    """Return the directory with the sources, with a project of .NET Standard 2.0 for each assembly."""
    return str(_HERE)


def assembly_directory() -> str:
    """The user's directory with the compiled assemblies; the first call compiles them with Mono's compiler.

    Raises Unsupported if the native libraries or a compiler are missing, or if the compiler fails.
    """
    made = os.path.join(state_directory(), "dotnet", _key(library_directory()))
    if not os.path.isdir(made):
        os.makedirs(os.path.dirname(made), exist_ok=True)
        _fill(made)
    return made


def _key(libraries: str) -> str:
    """Return a key of the sources and of the libraries' place, which is written into the assemblies."""
    digest = hashlib.sha256(f"{libraries}\n".encode())
    for source in (*sorted(_HERE.rglob("*.cs")), Path(__file__)):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _fill(made: str) -> None:
    """Compile all assemblies, then rename their folder to `made`, unless another process has done the same before."""
    compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
    if compiler is None:
        raise Unsupported(
            "no C# compiler is here (apt-get install mono-mcs mono-runtime); with .NET's own: "
            f"dotnet build {_HERE / 'Ixxat.Vci4.csproj'} -o DIRECTORY"
        )
    with tempfile.TemporaryDirectory(dir=os.path.dirname(made)) as scratch:
        home = os.path.join(scratch, "assemblies")
        os.mkdir(home)
        for one in _ASSEMBLIES:
            _compile(compiler, one, home, scratch)
        try:
            os.rename(home, made)
        except OSError:
            if not os.path.isdir(made):
                raise


def _compile(compiler: str, one: _Assembly, home: str, scratch: str) -> None:
    facts = os.path.join(scratch, f"{one.name}.cs")
    libraries = library_directory().replace('"', '""')
    with open(facts, "w", encoding="utf-8", newline="\n") as file:
        file.write(
            f'[assembly: System.Reflection.AssemblyVersion("{one.version}")]\n'
            f'[assembly: System.Reflection.AssemblyMetadata("CanwireLibraries", @"{libraries}")]\n'
        )
    sources = [str(source) for folder in one.folders for source in sorted((_HERE / folder).glob("*.cs"))]
    references = [f"-reference:{os.path.join(home, name)}.dll" for name in one.references]
    output = os.path.join(home, f"{one.name}.dll")
    ended = subprocess.run(
        [compiler, "-nologo", "-unsafe", "-optimize", "-target:library", f"-out:{output}", *one.options,
         *references, facts, *sources],
        capture_output=True, text=True,
    )  # fmt: skip
    if ended.returncode:
        raise Unsupported(
            f"{compiler} could not compile {one.name}: {(ended.stdout + ended.stderr).strip()[:1000]}"
        )
