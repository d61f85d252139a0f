"""Source distributions of other packages: fetched by pip into a folder, unpacked for a run of tests, never committed.

python -m tests.others.packages FOLDER
CANWIRE_OTHERS=FOLDER python -m pytest tests/others
"""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

NAMES = ("python-can", "cantools", "canmatrix", "ldfparser")
"""pip cannot prepare asammdf's without scikit-build-core; SavvyCAN and opendbc are not on PyPI as such."""


def fetch(folder: Path) -> None:
    """Ask pip for the newest source distribution of each."""
    for name in NAMES:
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--no-binary", ":all:"]
        subprocess.run([*pip, "--dest", str(folder), name], check=True)


def unpacked(into: Path) -> Path:
    """All of them in this folder; skips where CANWIRE_OTHERS names no folder with some."""
    folder = os.environ.get("CANWIRE_OTHERS", "")
    found = sorted(Path(folder).glob("*.tar.gz")) if folder else []
    if not found:
        pytest.skip("CANWIRE_OTHERS names no folder with other packages' data: see tests/others/packages.py")
    for archive in found:
        with tarfile.open(archive) as opened:
            opened.extractall(into, filter="data")
    return into


if __name__ == "__main__":
    fetch(Path(sys.argv[1]))
