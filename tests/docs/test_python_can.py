"""docs/python-can.md as it stands: its programs print what the page shows."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cold import ROOT, entry_points
from tests.hubs import serving

GUIDE = (ROOT / "docs" / "python-can.md").read_text(encoding="utf-8")
PROGRAM = re.compile(
    r"<!-- (?:run|start): (\w+) -->\n```python\n(.*?)^```$(?:\n+```text\n(.*?)^```$)?", re.M | re.S
)
PROGRAMS = {name: (text, shown) for name, text, shown in PROGRAM.findall(GUIDE)}
LONG = 60


@pytest.fixture
def environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Of a terminal where canwire is installed, and no hub runs."""
    paths = [entry_points(tmp_path), str(ROOT / "src"), os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, paths)))
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    return dict(os.environ)


def printed(name: str, environment: dict[str, str], folder: Path) -> str:
    command = [sys.executable, "-c", PROGRAMS[name][0]]
    return subprocess.run(
        command, env=environment, cwd=folder, capture_output=True, text=True, timeout=LONG, check=True
    ).stdout


@pytest.mark.finding("python-can 6")
def test_the_first_program_runs_as_printed(environment: dict[str, str], tmp_path: Path) -> None:
    text, shown = PROGRAMS["first"]
    assert len([line for line in text.splitlines() if line]) <= 10
    assert printed("first", environment, tmp_path) == shown


@pytest.mark.finding("python-can 5", "python-can 6")
def test_programs_in_several_terminals(environment: dict[str, str], tmp_path: Path) -> None:
    with serving(tmp_path, time="real") as served:
        environment = {**environment, "CANWIRE_HUB": served.address}
        command = [sys.executable, "-c", PROGRAMS["answering"][0]]
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as answering:
            assert answering.stdout is not None
            assert answering.stdout.readline() == "ready\n"
            assert printed("asking", environment, tmp_path) == PROGRAMS["asking"][1]
            answering.kill()
