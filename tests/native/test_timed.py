"""Programs in C++ that keep one time with others, on a hub in lockstep."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests import warm
from tests.hubs import LONG_S
from tests.native.conftest import Native

TESTER = """\
0: 101 0 at 252, tick 0
0: 101 1 at 486, tick 0
5: 101 2 at 5716, tick 0
15: 101 3 at 15946, tick 1
31: 101 4 at 31178, tick 3
51: 101 5 at 51408, tick 5
76: 101 6 at 76638, tick 7
106: 101 7 at 106870, tick 10
"""
ECU = "silent at 156\n"  # 50 ms after the last answer
WATCHER = "0 1 2 3 4 5 6 7 until 166\n"
READER = "8 until 176, error 1460\n"  # ERROR_TIMEOUT


def play(programs: Mapping[str, Path], home: Path) -> tuple[str, ...]:
    """What they print, each under its name."""
    address = str(home / "hub.sock")
    settings = {**os.environ, "CANWIRE_HUB": address, "CANWIRE_PYTHON": sys.executable, "CANWIRE_TIMED": "1"}
    pipe = subprocess.PIPE
    serve = ["serve", "--time", "lockstep", "--programs", ",".join(programs), "--socket", address]
    with ExitStack() as running:
        hub = running.enter_context(
            warm.Popen([sys.executable, "-m", "canwire", *serve], stdout=pipe, text=True)
        )
        running.callback(hub.terminate)
        assert "lockstep" in hub.stdout.readline()
        started = []
        for name, program in programs.items():
            (home / name).symlink_to(program)
            words = [str(home / name)]
            started.append(
                running.enter_context(subprocess.Popen(words, env=settings, stdout=pipe, text=True))
            )
        said = tuple(one.communicate(timeout=LONG_S)[0] for one in started)
        assert not any(one.returncode for one in started), said
        return said


@pytest.mark.conforms("N-39", "N-40", "N-41")
def test_waits_clocks_threads_and_locks_are_the_hubs_time(native: Native, tmp_path: Path) -> None:
    both = native.build("timed.cpp", "vciapi")
    watcher = native.build("timed.c", "vcinpl", "vciapi")
    reader = native.build("timed_candrv.c", "candrv")
    said = play({"ecu": both, "tester": both, "watcher": watcher, "candrv": reader}, tmp_path)
    assert said == (ECU, TESTER, WATCHER, READER)
