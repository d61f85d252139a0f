"""`canwire serve --dongle`: the hub's boards and a serial adapter at the same time."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from canwire import connect
from tests import warm

serial = pytest.importorskip("serial")
LONG = 30


@pytest.mark.smoke
@pytest.mark.conforms("CT-14")
def test_a_hub_with_a_dongle(tmp_path: Path) -> None:
    socket, link = str(tmp_path / "hub.sock"), tmp_path / "dongle"
    command = [sys.executable, "-m", "canwire", "serve", "--socket", socket, "--dongle", str(link)]
    with warm.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert "canwire hub on" in process.stdout.readline()
        assert str(link) in process.stdout.readline()
        with serial.Serial(str(link), timeout=LONG) as port:
            port.write(b"V\r")
            assert port.read_until(b"\r") == b"V1013\r"
        with connect(socket) as hub:
            assert hub.board("canbus-dongle").lines[0].bus == "can0"
        process.terminate()
        assert process.wait(LONG) == 0
    assert not link.exists()
