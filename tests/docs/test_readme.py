"""README.md as it stands: its programs print what it says, its three terminals show what they should."""

from __future__ import annotations

import contextlib
import io
import json
import select
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from canwire.commands import main
from tests.cold import PYTEST
from tests.docs.blocks import ROOT, blocks
from tests.docs.test_five_programs import Terminals, line

PAGE = ROOT / "README.md"  # README.md's program for VCI is run by test_porting_vci.py
LAB, TEST = [block.text for block in blocks(PAGE) if block.language == "python" and not block.mark]
(CONSOLE,) = [block.text.splitlines() for block in blocks(PAGE) if block.language == "console"]
DEVICE = """
import canwire


class MyDevice(canwire.NodeScript):
    def on_start(self):
        self.node.send(canwire.Frame(0x701, b"\\x05"))


"""


@pytest.mark.smoke
@pytest.mark.conforms("N-15")
def test_three_lines_to_a_bus() -> None:
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(compile(LAB, "<README.md>", "exec"), {"__name__": "readme"})
    frame, counters = output.getvalue().splitlines()
    assert f"# {frame}\n" in LAB
    assert f"# ... {counters}: an error frame" in LAB


@pytest.mark.smoke
@pytest.mark.conforms("N-15")
def test_in_your_tests(tmp_path: Path) -> None:
    (tmp_path / "test_device.py").write_text(DEVICE + TEST)
    command = [*PYTEST, "."]
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert "1 passed" in ended.stdout, ended.stdout + ended.stderr


@pytest.mark.smoke
@pytest.mark.conforms("N-15")
def test_a_log_on_a_simulated_bus(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = "play examples/car-candump.log --bus can0"
    assert f"canwire {words}\n" in PAGE.read_text(encoding="utf-8")
    monkeypatch.chdir(ROOT)
    assert main(words.split()) == 0
    assert "can0" in capsys.readouterr().out


@pytest.fixture
def terminals(tmp_path: Path) -> Iterator[Terminals]:
    made = Terminals(tmp_path)
    yield made
    made.close()


@pytest.mark.smoke
@pytest.mark.conforms("N-15")
@pytest.mark.realtime
def test_shared_boards(terminals: Terminals, tmp_path: Path) -> None:
    serve, dump, send, devices = [line.removeprefix("$ canwire ") for line in CONSOLE]
    assert "canwire hub on" in line(terminals.command(f"{serve} --socket {tmp_path / 'hub.sock'}"))
    heard = terminals.command(dump)
    json_of = f"{devices} --json"
    while not any(one["running"] for one in _lines(terminals, json_of)):
        assert heard.poll() is None
    assert heard.stdout is not None
    status = None
    while not select.select([heard.stdout], [], [], 0)[0]:  # its line runs a moment before it listens
        status = terminals.command(send).wait(60)
    assert status == 0
    assert line(heard).split()[-4:] == ["123", "[2]", "11", "22"]
    shown, _ = terminals.command(devices).communicate(timeout=60)
    assert "HW000001  usb-to-can-fd" in shown


def _lines(terminals: Terminals, words: str) -> list[dict[str, object]]:
    shown, _ = terminals.command(words).communicate(timeout=60)
    return [each["status"] for board in json.loads(shown)["boards"] for each in board["lines"]]
