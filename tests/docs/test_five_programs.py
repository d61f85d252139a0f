"""docs/five-programs.md as it stands: five interfaces, five processes, one bus."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests import warm
from tests.cold import entry_points

pytest.importorskip("serial")
ROOT = Path(__file__).resolve().parent.parent.parent
GUIDE = ROOT / "docs" / "five-programs.md"
PROGRAM = re.compile(r"<!-- program: (\S+) (\w+) -->\n```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^\$ canwire (.*)$", re.MULTILINE)
SHOWN = re.compile(r"^```text\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LONG = 60  # seconds after which something that should happen never will


class Terminals:
    """Every process of the page, in one directory, on one hub."""

    def __init__(self, folder: Path) -> None:
        paths = [entry_points(folder), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
        self._environment = {
            **os.environ,
            "CANWIRE_HUB": str(folder / "hub.sock"),
            "PYTHONPATH": os.pathsep.join(map(os.path.abspath, paths)),
        }
        self._folder = folder
        self._closing = ExitStack()

    def start(self, *words: str) -> subprocess.Popen[str]:
        python_can = any("import can\n" in word for word in words)  # it finds us while it is loaded
        process = (subprocess.Popen if python_can else warm.Popen)(
            [sys.executable, *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=self._folder,
            env=self._environment,
        )
        self._closing.callback(process.communicate)
        self._closing.callback(process.kill)
        return process

    def command(self, words: str) -> subprocess.Popen[str]:
        return self.start("-m", "canwire", *words.split())

    def close(self) -> None:
        self._closing.close()


@pytest.fixture
def terminals(tmp_path: Path) -> Iterator[Terminals]:
    made = Terminals(tmp_path)
    yield made
    made.close()


def line(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().strip()


@pytest.mark.smoke
@pytest.mark.conforms("PL-13", "PL-01", "CT-21", "FS-20", "AC-21", "X3-19")
def test_everybody_hears_everybody(terminals: Terminals, tmp_path: Path) -> None:
    page = GUIDE.read_text(encoding="utf-8")
    serve, go = COMMAND.findall(page)
    expected = SHOWN.findall(page)[0].splitlines()
    hub = terminals.command(f"{serve} --socket {tmp_path / 'hub.sock'}")
    assert "canwire hub on" in line(hub)
    assert "ttyCANBUS0" in line(hub)
    programs = {number: terminals.start("-c", text) for _, number, text in PROGRAM.findall(page)}
    assert len(programs) == len(expected) == 5
    for process in programs.values():
        assert line(process) == "ready"
    assert terminals.command(go).wait(LONG) == 0
    for number, process in programs.items():
        heard = [line(process) for _ in range(4)]
        assert heard == [other for other in expected if not other.startswith(number)]
