"""What leaves this clone is whole: the source distribution, the wheel that is built from it, a clone on its own.

`.ci/run` does the same at full length: compiled, with README's own commands and everything they install. So here the
wheel is only unpacked, and one file of tests stands for all.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from docs import conformance

ROOT = Path(__file__).resolve().parent.parent
NOT_TAKEN = shutil.ignore_patterns(".*", "__pycache__", "*.so", "build", "dist", "*.egg-info")
TESTS = "tests/lab/test_scripts.py"


def run(*words: str, home: Path, source: Path | None = None, **environment: str) -> str:
    """Python with these words where no compiler is, and no canwire but that of `source`."""
    bare = {name: value for name, value in os.environ.items() if not name.startswith(("CANWIRE", "PYTHON"))}
    bare |= {
        "PATH": str(Path(sys.executable).parent),
        "CC": "/nonexistent",
        "CANWIRE_BUILD": "pure",
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",  # half of what the tests below would take
    } | environment
    if source:
        bare["PYTHONPATH"] = str(source)
    ended = subprocess.run([sys.executable, *words], cwd=home, env=bare, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source distribution, unpacked where nothing else is."""
    setuptools = pytest.importorskip("setuptools", minversion="77")  # what pyproject.toml asks for
    assert setuptools
    clone, made = tmp_path_factory.mktemp("clone") / "canwire", tmp_path_factory.mktemp("unpacked")
    shutil.copytree(ROOT, clone, ignore=NOT_TAKEN)
    shutil.copytree(ROOT / ".ci", clone / ".ci")
    sdist = ("sdist", "--formats", "tar")  # not compressed, as it is unpacked here
    run("setup.py", "-q", *sdist, "--dist-dir", str(made), home=clone)
    (archive,) = made.glob("canwire-*.tar")
    with tarfile.open(archive) as tar:
        tar.extractall(made, filter="data")
    return next(path for path in made.iterdir() if path.is_dir())


@pytest.mark.long
@pytest.mark.conforms("N-17")
def test_readmes_two_commands_find_what_they_need_in_the_source_distribution(unpacked: Path) -> None:
    first, second = re.findall(
        r"^    python3 -m venv .venv && (.*)$", (unpacked / "README.md").read_text("utf-8"), re.MULTILINE
    )
    played = first.partition(".venv/bin/canwire ")[2].split()
    assert "can0" in run("-m", "canwire", *played, home=unpacked, source=unpacked / "src")
    assert ".venv/bin/python -m pytest" in second
    made = {".hypothesis", "__pycache__"}  # where other processes write at this moment
    files = [path for path in (ROOT / "tests").rglob("*") if path.is_file() and not made & set(path.parts)]
    names = [path.relative_to(ROOT) for path in files if path.suffix != ".so"]
    assert [str(name) for name in names if not (unpacked / name).exists()] == []


@pytest.mark.long
@pytest.mark.conforms("N-16")
def test_a_wheel_is_made_without_a_compiler_and_passes_tests(unpacked: Path, tmp_path: Path) -> None:
    run("setup.py", "-q", "bdist_wheel", "--dist-dir", str(tmp_path), home=unpacked)
    (wheel,) = tmp_path.glob("canwire-*.whl")
    assert wheel.name.endswith("-py3-none-any.whl")
    installed = tmp_path / "installed"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(installed)
    shutil.copytree(unpacked / "tests", tmp_path / "tests")
    shutil.copy(unpacked / "pyproject.toml", tmp_path)
    assert "uncompiled" in run("-m", "canwire", "--version", home=tmp_path, source=installed)
    where = run("-c", "import canwire; print(canwire.__file__)", home=tmp_path, source=installed)
    assert Path(where.strip()).is_relative_to(installed)
    words = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "pytest_timeout"]
    said = run(*words, TESTS, home=tmp_path, source=installed)
    assert " passed" in said


@pytest.mark.conforms("N-18")
def test_a_clone_alone_makes_the_conformance_page(tmp_path: Path) -> None:
    clone = tmp_path / "canwire"
    for folder in ("docs", "tests"):
        shutil.copytree(ROOT / folder, clone / folder, ignore=NOT_TAKEN)
    (clone / "docs" / "conformance.md").unlink()
    run("docs/conformance.py", home=clone)
    behaviours = conformance.BEHAVIOURS.read_text("utf-8")
    assert (clone / "docs" / "conformance.md").read_text("utf-8") == conformance.page(behaviours)
