"""native-drivers.md: its commands build programs in C."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from canwire.native import library_directory
from tests import warm
from tests.docs.blocks import ROOT, blocks
from tests.missing import needs_program, supported

PROGRAMS = ROOT / "tests" / "native" / "drivers" / "programs"


def fenced(language: str) -> list[str]:
    page = ROOT / "docs" / "native-drivers.md"
    return [block.text for block in blocks(page) if block.language == language]


@needs_program("gcc")
def test_the_commands_build_programs(tmp_path: Path) -> None:
    supported(library_directory)
    for source, name in (("candrv.c", "CanRead.c"), ("acan.c", "wct32.c"), ("checks.h", "checks.h")):
        shutil.copy(PROGRAMS / source, tmp_path / name)
    warm.write_script(tmp_path / "canwire")
    settings = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    [words] = fenced("sh")
    done = subprocess.run(
        ["sh", "-e"], input=words, cwd=tmp_path, env=settings, text=True, capture_output=True
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "CanRead").exists()
    assert (tmp_path / "wct32").exists()
