"""Where a platform cannot reach hubs of other machines, it says so in one line."""

from __future__ import annotations

import os
import subprocess
import sys

from tests.hubs import LONG_S


def test_the_portable_platform_says_that_it_cannot() -> None:
    ended = subprocess.run(
        [sys.executable, "-m", "canwire", "dump", "can0", "--hub", "zenoh://lab/bench1"],
        env=os.environ | {"CANWIRE_PLATFORM": "portable"},
        capture_output=True,
        text=True,
        timeout=LONG_S,
    )
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr.startswith("canwire: hubs of other machines are reached from Linux alone so far")
    assert ended.stderr.count("\n") == 1
