"""What leaves this clone is whole: the source distribution, the wheel that is built from it, a clone on its own.

`.ci/run` does the same at full length: compiled, with README's own commands and everything they install.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

from docs import conformance

ROOT = Path(__file__).resolve().parent.parent
NOT_TAKEN = shutil.ignore_patterns(".*", "__pycache__", "*.so", "build", "dist", "*.egg-info")
FEW = ("tests/values/test_checks.py", "tests/lab/test_scripts.py")


def run(*words: str, home: Path, source: Path | None = None, **environment: str) -> str:
    """Python with these words where no compiler is, and no canwire but that of `source`."""
    bare = {name: value for name, value in os.environ.items() if not name.startswith(("CANWIRE", "PYTHON"))}
    bare |= {
        "PATH": str(Path(sys.executable).parent),
        "CC": "/nonexistent",
        "CANWIRE_BUILD": "pure",
    } | environment
    if source:
        bare["PYTHONPATH"] = str(source)
    ended = subprocess.run([sys.executable, *words], cwd=home, env=bare, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


def passes(home: Path, source: Path, *tests: str) -> None:
    where = run("-c", "import canwire; print(canwire.__file__)", home=home, source=source)
    assert Path(where.strip()).is_relative_to(source)
    assert " passed" in run("-m", "pytest", "-q", "-p", "no:cacheprovider", *tests, home=home, source=source)


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source distribution, unpacked where nothing else is."""
    setuptools = pytest.importorskip("setuptools", minversion="77")  # what pyproject.toml asks for
    assert setuptools
    clone, made = tmp_path_factory.mktemp("clone") / "canwire", tmp_path_factory.mktemp("unpacked")
    shutil.copytree(ROOT, clone, ignore=NOT_TAKEN)
    shutil.copytree(ROOT / ".ci", clone / ".ci")
    run("setup.py", "-q", "sdist", "--dist-dir", str(made), home=clone)
    (archive,) = made.glob("canwire-*.tar.gz")
    with tarfile.open(archive) as tar:
        tar.extractall(made, filter="data")
    return next(path for path in made.iterdir() if path.is_dir())


@pytest.mark.conforms("N-17")
def test_readmes_two_commands_find_what_they_need_in_the_source_distribution(unpacked: Path) -> None:
    first, second = re.findall(
        r"^    python3 -m venv .venv && (.*)$", (unpacked / "README.md").read_text("utf-8"), re.MULTILINE
    )
    played = first.partition(".venv/bin/canwire ")[2].split()
    assert "can0" in run("-m", "canwire", *played, home=unpacked, source=unpacked / "src")
    assert ".venv/bin/python -m pytest" in second
    names = {
        path.relative_to(ROOT)
        for path in (ROOT / "tests").rglob("*")
        if path.suffix not in (".pyc", ".so") and path.is_file()
    }
    assert (
        sorted(
            str(name) for name in names if not (unpacked / name).exists() and ".hypothesis" not in name.parts
        )
        == []
    )
    passes(unpacked, unpacked / "src", FEW[0])


@pytest.mark.conforms("N-16")
def test_a_wheel_is_made_and_installed_without_a_compiler_and_passes_tests(
    unpacked: Path, tmp_path: Path
) -> None:
    run("setup.py", "-q", "bdist_wheel", "--dist-dir", str(tmp_path), home=unpacked)
    (wheel,) = tmp_path.glob("canwire-*.whl")
    assert wheel.name.endswith("-py3-none-any.whl")
    installed = tmp_path / "installed"
    run(
        "-m",
        "pip",
        "install",
        "-q",
        "--no-index",
        "--no-deps",
        "--no-compile",  # 1,200 files, of which the tests below use a part
        "--target",
        str(installed),
        str(wheel),
        home=tmp_path,
    )
    shutil.copytree(unpacked / "tests", tmp_path / "tests")
    shutil.copy(unpacked / "pyproject.toml", tmp_path)
    assert "uncompiled" in run("-m", "canwire", "--version", home=tmp_path, source=installed)
    passes(tmp_path, installed, *FEW)


@pytest.mark.conforms("N-18")
def test_a_clone_alone_makes_the_conformance_page(tmp_path: Path) -> None:
    clone = tmp_path / "canwire"
    for folder in ("docs", "tests"):
        shutil.copytree(ROOT / folder, clone / folder, ignore=NOT_TAKEN)
    (clone / "docs" / "conformance.md").unlink()
    run("docs/conformance.py", home=clone)
    behaviours = conformance.BEHAVIOURS.read_text("utf-8")
    assert (clone / "docs" / "conformance.md").read_text("utf-8") == conformance.page(behaviours)
