"""Which tests judge a mutant, and in which order."""

from __future__ import annotations

import re
from pathlib import Path

from tests.mutants.drawing import PACKAGE, Mutant

FIRST = 8  # as many test files that mention what was changed run before the others


def stages(root: Path, mutant: Mutant) -> list[list[str]]:
    """The test files of the mutant's folder and of those above it: the ones that mention it first, then the others."""
    files = [path.relative_to(root).as_posix() for path in _judges(root, mutant)]
    merit = {file: _merit((root / file).read_text("utf-8"), mutant) for file in files}
    files.sort(key=lambda file: -merit[file])  # sorting keeps the nearest folder first among equals
    first = [file for file in files[:FIRST] if merit[file]]
    return [stage for stage in (first, files[len(first) :]) if stage]


def _judges(root: Path, mutant: Mutant) -> list[Path]:
    inner = Path(mutant.file).relative_to(PACKAGE)
    tests = root / "tests"
    found: list[Path] = []
    for above in inner.parents[:-1]:
        found += sorted((tests / above).rglob("test_*.py"))
    if {"loopback", "portable"} & set(inner.parts):
        found.append(tests / "platform/test_portable_suite.py")  # which Linux runs only there
    found += sorted(tests.glob(f"test_{(inner.parts[0] if len(inner.parts) > 1 else inner.stem)}*.py"))
    return list(dict.fromkeys(found)) or _of_those_who_use_it(root, mutant)


def _of_those_who_use_it(root: Path, mutant: Mutant) -> list[Path]:
    """For a file without tests of its own: the tests of the top folders whose source imports it."""
    users = [path for path in (root / PACKAGE).rglob("*.py") if _imports(path.read_text("utf-8"), mutant)]
    tops = sorted({path.relative_to(root / PACKAGE).parts[0] for path in users})
    return [path for top in tops for path in sorted((root / "tests" / top).rglob("test_*.py"))]


def _merit(text: str, mutant: Mutant) -> int:
    """How probably a test file of this text notices the mutant."""
    names = [name for name in mutant.inside.split(".") if not name.startswith("__")]
    stem = Path(mutant.file).stem
    named = sum(bool(re.search(rf"\b{name}\b", text)) for name in names)
    return 4 * _imports(text, mutant) + 2 * named + bool(re.search(rf"\b{stem}\b", text))


def _imports(text: str, mutant: Mutant) -> bool:
    module = mutant.file.removeprefix("src/").removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    package, _, name = module.rpartition(".")
    direct = rf"^\s*(from {re.escape(module)} import|import {re.escape(module)}\b)"
    return bool(re.search(rf"{direct}|^\s*from {re.escape(package)} import .*\b{name}\b", text, re.MULTILINE))
