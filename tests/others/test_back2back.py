"""python-can's own back-to-back tests, on two buses of ours: every one of them passes."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.hubs import serving
from tests.others.packages import unpacked

pytestmark = [pytest.mark.realtime, pytest.mark.conforms("PL-01")]
pytest.importorskip("can")
OURS = """
import can
import test.back2back_test as theirs


class TestBuses(theirs.Back2BackTestCase):
    INTERFACE_1 = INTERFACE_2 = "canwire"
    CHANNEL_1 = CHANNEL_2 = "can0"


class TestThreadSafeBuses(TestBuses):
    def setUp(self):
        self.bus1, self.bus2 = (
            can.ThreadSafeBus(
                channel="can0", interface="canwire", bitrate=self.BITRATE, fd=theirs.TEST_CAN_FD, single_handle=True
            )
            for _ in range(2)
        )
"""
LEAST = 28  # in python-can 4.6: fourteen tests, twice


def test_all_of_them_pass(tmp_path: Path) -> None:
    root = unpacked(tmp_path / "others")
    (package,) = root.glob("python_can-*")
    (package / "tox.ini").unlink(missing_ok=True)  # options for plug-ins that are not here
    (package / "test" / "test_on_canwire.py").write_text(OURS)
    with serving(tmp_path, time="real") as served:
        ended = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-c", os.devnull, "--rootdir", ".",
             "test/test_on_canwire.py"],
            cwd=package, env={**os.environ, "CANWIRE_HUB": served.address}, capture_output=True, text=True,
            timeout=600,
        )  # fmt: skip
    assert ended.returncode == 0, ended.stdout + ended.stderr
    passed = re.search(r"(\d+) passed", ended.stdout)
    assert passed is not None, ended.stdout
    assert int(passed[1]) >= LEAST
