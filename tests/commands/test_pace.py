"""`canwire serve --pace` and `canwire pace`: a lockstep hub's time by the wall clock."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import canwire
from canwire import BadValue, WrongState
from canwire.commands import main
from tests import warm
from tests.cases import each
from tests.hubs import LONG_S, serving, status_of
from tests.lockstep.programs import bench

STEPS = """
import canwire
with canwire.connect() as hub:
    hub.sleep(0.025)
    hub.set_pace({pace})
    hub.sleep(3600)
    print(hub.now_ns(), hub.time_state().pace)
"""


@pytest.fixture
def says(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    def said(*words: str) -> str:
        assert main(list(words)) == 0
        return capsys.readouterr().out

    return said


def test_a_program_frees_a_hub_that_was_held_to_the_clock(tmp_path: Path, says: Callable[..., str]) -> None:
    with bench(tmp_path, "--pace", "10") as made:
        hub = ("--hub", made.address)
        assert "time passes 10 times as quickly as the clock, 0.000000000 s" in says("pace", *hub)
        assert "  held to 10 times the clock" in says("devices", *hub)
        assert json.loads(says("devices", "--json", *hub))["lockstep"]["pace"] == 10
        assert "0.5 times" in says("pace", "0.5", *hub)
        assert made.run({"steps": STEPS.format(pace=None)})["steps"] == "3600025000000 0.0\n"
        assert "as quickly as it can, 3600.025000000 s have passed" in says("pace", *hub)


def test_a_hub_of_the_program_s_own_is_held_and_freed() -> None:
    with canwire.connect(time="lockstep", timed=True) as hub:
        hub.set_pace(1000)
        hub.sleep(0.5)
        assert (hub.now_ns(), hub.time_state().pace) == (500_000_000, 1000)
        hub.set_pace(None)
        hub.sleep(3600)
        assert hub.now_ns() == 3_600_500_000_000


@each("factor", [0, -1, float("nan"), float("inf"), 1e-9, 1e9])
def test_a_pace_is_a_number_within_bounds(factor: float) -> None:
    with canwire.connect(time="lockstep", timed=True) as hub, pytest.raises(BadValue, match="pace"):
        hub.set_pace(factor)


def test_other_hubs_have_no_pace(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with canwire.connect(time="fast") as hub, pytest.raises(WrongState, match="with the clock"):
        hub.set_pace(1)
    with serving(tmp_path) as served:
        assert main(["pace", "1", "--hub", served.address]) == 2
    assert "this one's time is fast" in capsys.readouterr().err
    assert main(["serve", "--time", "fast", "--pace", "1"]) == 2
    assert "--pace are for --time lockstep" in capsys.readouterr().err
    for word in ("0", "-1", "slow"):
        assert status_of("pace", word) == 2
        assert "a number above 0, or free" in capsys.readouterr().err


def test_a_serial_dongle_is_refused_unless_time_is_held_to_the_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    with bench(tmp_path) as made:
        words = ["slcan", "--pty", str(tmp_path / "tty"), "--hub", made.address]
        assert main(words) == 2
        assert "canwire pace 1" in capfd.readouterr().err
        assert main(["pace", "1", "--hub", made.address]) == 0
        command = [sys.executable, "-m", "canwire", *words]
        dongle = warm.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert dongle.stdout is not None
        assert "dongle A123" in dongle.stdout.readline()
        dongle.terminate()
        dongle.communicate(timeout=LONG_S)
