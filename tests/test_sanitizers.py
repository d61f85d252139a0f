"""When .ci/sanitizers looks at the core: whenever it is not the one that passed last, whatever history a clone has."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SCRIPT = ROOT / ".ci" / "sanitizers"

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or not SCRIPT.exists(), reason="a script of this repository, for Linux"
)


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """What the script looks at, without any history."""
    for name in (".ci/sanitizers", ".ci/walls.py", "setup.py", "src/canwire/ring.py", "src/canwire/ring.pxd",
                 "src/canwire/errors.py"):  # fmt: skip
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


def looks(clone: Path) -> bool:
    asked = subprocess.run(
        ["bash", ".ci/sanitizers", "--ask"], cwd=clone, capture_output=True, text=True, timeout=60
    )
    assert asked.returncode in (0, 1), asked.stderr
    return asked.returncode == 1


def passed(clone: Path) -> None:
    """As a run that found nothing writes it down."""
    script = (clone / ".ci" / "sanitizers").read_text()
    said = script.partition("work=${SANITIZED")[0] + '\necho "$now" >"$root/.ci/sanitized"\n'
    subprocess.run(["bash", "-s", "--", "--always"], input=said.replace('$(dirname "$0")/..', "."), text=True,
                   cwd=clone, check=True, timeout=60)  # fmt: skip


@pytest.mark.parametrize(
    "changed", ["src/canwire/ring.py", "src/canwire/ring.pxd", "setup.py", ".ci/sanitizers"]
)
def test_a_core_that_has_not_passed_is_looked_at(clone: Path, changed: str) -> None:
    assert looks(clone)  # never looked at
    passed(clone)
    assert not looks(clone)
    with (clone / changed).open("a") as file:
        file.write("\n# another line\n")
    assert looks(clone)


def test_other_files_and_a_new_one(clone: Path) -> None:
    passed(clone)
    with (clone / "src" / "canwire" / "errors.py").open("a") as file:
        file.write("\n# not compiled\n")
    assert not looks(clone)
    for ending in (".py", ".pxd"):
        shutil.copy(clone / f"src/canwire/ring{ending}", clone / f"src/canwire/other{ending}")
    assert looks(clone)
