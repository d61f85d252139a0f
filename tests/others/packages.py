"""Source distributions of other packages: fetched by pip into a folder, unpacked for a run of tests, never committed.

python -m tests.others.packages FOLDER
CANWIRE_OTHERS=FOLDER python -m pytest tests/others
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

NAMES = ("python-can", "cantools", "canmatrix", "ldfparser")
WHEELS = ("opendbc",)
"""Its wheel carries the databases, npm's axe-core what tests/web/test_axe.py runs. pip cannot prepare asammdf's
source without scikit-build-core; SavvyCAN is in no package."""


AXE = "axe-core-*.tgz"


def fetch(folder: Path) -> None:
    """Ask pip for the newest source distribution, or wheel, of each."""
    for name in (*NAMES, *WHEELS):
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", str(folder)]
        kind = ["--only-binary" if name in WHEELS else "--no-binary", ":all:"]
        subprocess.run([*pip, *kind, name], check=True)
    if npm := shutil.which("npm"):
        subprocess.run([npm, "pack", "axe-core@4", "--silent"], cwd=folder, check=True)


def unpacked(into: Path) -> Path:
    """All of them in this folder; skips where CANWIRE_OTHERS names no folder with some."""
    folder = os.environ.get("CANWIRE_OTHERS", "")
    found = sorted(Path(folder).glob("*.tar.gz")) if folder else []
    if not found:
        pytest.skip("CANWIRE_OTHERS names no folder with other packages' data: see tests/others/packages.py")
    for archive in found:
        with tarfile.open(archive) as opened:
            opened.extractall(into, filter="data")
    for wheel in sorted(Path(folder).glob("*.whl")):
        with zipfile.ZipFile(wheel) as packed:
            packed.extractall(into / wheel.stem)
    return into


if __name__ == "__main__":
    fetch(Path(sys.argv[1]))
