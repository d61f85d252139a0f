"""Compiles of a commit's core what no other folder has compiled from the same sources.

An extension's sources are its own file, its declarations and all that these cimport, and what setup.py says of it.

    python builds.py NAME ...      in a commit's folder: compiles these extensions in place
"""

from __future__ import annotations

import ast
import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import NamedTuple

_CIMPORT = re.compile(r"^\s*(?:from\s+([\w.]+)\s+)?cimport\s+(\([^)]*\)|[^#\n]+)", re.MULTILINE)
_SUFFIX = str(sysconfig.get_config_var("EXT_SUFFIX"))


class Compiled(NamedTuple):
    """A folder with the package canwire, compiled files included, and the setup.py that compiled it."""

    source: Path
    setup: Path


def recipes(source: Path, setup: Path) -> dict[str, str]:
    """For each extension of the core a checksum of all that it is made of."""
    described = ast.parse(setup.read_text("utf-8"))
    assigned = [node for node in described.body if isinstance(node, ast.Assign)]
    [core] = [node for node in assigned if ast.unparse(node.targets[0]) == "CORE"]
    described.body.remove(core)
    levels = ast.literal_eval(core.value)
    return {name: _checksum(source, name, f"{levels[name]} {ast.dump(described)}") for name in levels}


def _checksum(source: Path, name: str, described: str) -> str:
    found = hashlib.sha256(described.encode())
    for path in sorted(sources(source, name)):
        found.update(f"{path.relative_to(source)}\0".encode() + path.read_bytes() + b"\0")
    return found.hexdigest()


def sources(source: Path, name: str) -> set[Path]:
    """The file of this module, its declarations, and those that they cimport, directly or not."""
    stem = source / name.replace(".", "/")
    found, waiting = {stem.with_suffix(".py")}, [stem.with_suffix(".pxd")]
    while waiting:
        path = waiting.pop()
        if path in found or not path.exists():
            continue
        found.add(path)
        for package, names in _CIMPORT.findall(path.read_text("utf-8")):
            for word in names.strip("() \n").split(","):
                module = (word.split() or [""])[0]
                for candidate in {package or module, f"{package}.{module}"}:
                    stem = source / candidate.strip(".").replace(".", "/")
                    waiting += [stem.with_suffix(".pxd"), stem / "__init__.pxd"]
    return found


def build(folder: Path, others: list[Compiled]) -> list[str]:
    """Compile the core of a commit's folder in place; returns the names of what no other folder could give."""
    source, setup = folder / "src", folder / "setup.py"
    wanted, missing = recipes(source, setup), []
    offered = [(other.source, recipes(*other)) for other in others]
    for name in wanted:
        file = name.replace(".", "/") + _SUFFIX
        for other, theirs in offered:
            if theirs.get(name) == wanted[name] and (other / file).exists():
                shutil.copy2(other / file, source / file)
                break
        else:
            missing.append(name)
    if missing:
        compile_in(folder, missing)
    return missing


def compile_in(folder: Path, names: list[str]) -> None:
    print(f"compiling {len(names)} extensions of {folder.name}", file=sys.stderr, flush=True)
    environment = {**os.environ, "CANWIRE_BUILD": "require"}
    command = [sys.executable, str(Path(__file__).resolve()), *names]
    ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if ended.returncode:
        raise SystemExit(f"{folder.name} cannot be compiled:\n{ended.stderr[-3000:]}")


def _compile_here(names: list[str]) -> None:
    import setuptools  # noqa: F401 -- it brings distutils with it

    # isort: split
    from distutils.core import run_setup

    distribution = run_setup("setup.py", ["-q", "build_ext", "--inplace"], stop_after="commandline")
    distribution.ext_modules = [
        extension for extension in distribution.ext_modules if extension.name in names
    ]
    distribution.run_commands()


if __name__ == "__main__":
    _compile_here(sys.argv[1:])
