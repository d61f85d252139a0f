"""python-can's own back-to-back tests, between ports of ours: 44 of 44 pass."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from tests.hubs import serving
from tests.others.packages import unpacked

pytestmark = [pytest.mark.realtime, pytest.mark.conforms("PL-01")]
pytest.importorskip("can")
OURS = """
import can
import test.back2back_test as theirs


class TestOneLine(theirs.Back2BackTestCase):
    INTERFACE_1 = INTERFACE_2 = "canwire"
    CHANNEL_1 = CHANNEL_2 = "can0"


class TestTwoLines(theirs.Back2BackTestCase):
    INTERFACE_1 = INTERFACE_2 = "canwire"
    CHANNEL_1, CHANNEL_2 = "HW000001:0", "HW000001:1"


class TestThreadSafe(theirs.TestThreadSafeBus):
    INTERFACE_1 = INTERFACE_2 = "canwire"
    CHANNEL_1 = CHANNEL_2 = "can0"
"""
PASSED = {"TestOneLine": 14, "TestTwoLines": 14, "TestThreadSafe": 16}
"""Of python-can 4.6: each class inherits sixteen, two of which python-can itself skips; the last has two of its own."""
IN_CI = 1  # more of each it skips where `CI` is set: one that measures time


def test_all_of_them_pass(tmp_path: Path) -> None:
    root = unpacked(tmp_path / "others")
    (package,) = root.glob("python_can-*")
    (package / "tox.ini").unlink(missing_ok=True)  # options for plug-ins that are not here
    (package / "test" / "test_on_canwire.py").write_text(OURS)
    with serving(tmp_path, time="real") as served:
        ended = subprocess.run(
            [sys.executable, "-m", "pytest", "-v", "-p", "no:cacheprovider", "-c", os.devnull, "--rootdir", ".",
             "test/test_on_canwire.py"],
            cwd=package, env={**os.environ, "CANWIRE_HUB": served.address}, capture_output=True, text=True,
            timeout=600,
        )  # fmt: skip
    assert ended.returncode == 0, ended.stdout + ended.stderr
    passed = Counter(re.findall(r"::(\w+)::\w+ PASSED", ended.stdout))
    left_out = IN_CI if "CI" in os.environ else 0
    fewer = {name: passed[name] for name in PASSED if passed[name] < PASSED[name] - left_out}
    assert fewer == {}, ended.stdout
