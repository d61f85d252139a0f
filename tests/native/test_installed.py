"""Which Python a library in site-packages takes for its helper: that of its own environment."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from canwire.native import library_directory
from tests.hubs import LONG_S, Served
from tests.native.conftest import Native

PYTHON = """#!/bin/sh
echo "$0" > "$0.was-asked"
exec {python} "$@"
"""


def test_it_is_the_environments_own(native: Native, hub: Served, tmp_path: Path) -> None:
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    libraries = tmp_path / "lib" / version / "site-packages" / "canwire" / "native" / "lib"
    libraries.mkdir(parents=True)
    for library in Path(library_directory()).glob("*.so"):
        shutil.copy(library, libraries)
    python = tmp_path / "bin" / version
    python.parent.mkdir()
    python.write_text(PYTHON.format(python=sys.executable))
    python.chmod(0o755)
    settings = {name: value for name, value in os.environ.items() if name != "CANWIRE_PYTHON"}
    settings |= {"CANWIRE_HUB": hub.address, "LD_LIBRARY_PATH": str(libraries)}
    program = native.build("errors.cpp", "vciapi")
    ended = subprocess.run([program], env=settings, capture_output=True, text=True, timeout=LONG_S)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert Path(f"{python}.was-asked").read_text() == f"{python}\n"
