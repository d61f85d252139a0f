"""Programs in processes that keep one time, and end as they should not: killed, stopped, never come."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.hubs import LONG_S, status_of
from tests.lockstep.programs import Bench, bench

STEPS = """
import canwire
with canwire.connect() as hub:
    print("ready", flush=True)
    for _ in range(100):
        hub.sleep(0.010)
    print(hub.now_ns(), flush=True)
"""
KILLED = """
import canwire, os, signal
with canwire.connect() as hub:
    hub.sleep(0.055)
    os.kill(os.getpid(), signal.SIGKILL)
"""
ENDLESS = """
import canwire
with canwire.connect() as hub:
    print("ready", flush=True)
    while True:
        hub.sleep(0.010)
"""


def first_line(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().strip()


def devices(made: Bench) -> dict[str, object]:
    command = [sys.executable, "-m", "canwire", "devices", "--json", "--hub", made.address]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LONG_S, check=True)
    found: dict[str, object] = json.loads(done.stdout)["lockstep"]
    return found


@pytest.mark.conforms("N-36")
def test_a_killed_program_is_let_go_with_a_word_and_the_others_go_on(tmp_path: Path) -> None:
    with bench(tmp_path, "--programs", "a,b") as made:
        steps, killed = made.start("a", STEPS), made.start("b", KILLED)
        assert killed.wait(LONG_S) == -signal.SIGKILL
        assert [first_line(steps), first_line(steps)] == ["ready", "1000000000"]
        assert (
            made.hears("b (")
            == f"canwire: b ({killed.pid}) has left at 0.055000000 s: time continues without it"
        )


@pytest.mark.conforms("N-36")
def test_a_stopped_program_is_named_and_time_waits_on_for_it(tmp_path: Path) -> None:
    with bench(tmp_path, "--programs", "2", "--patience", "0.3") as made:
        endless, other = made.start("a", ENDLESS, cold=True), made.start("b", ENDLESS)
        assert [first_line(endless), first_line(other)] == ["ready", "ready"]
        os.kill(endless.pid, signal.SIGSTOP)
        os.waitid(os.P_PID, endless.pid, os.WSTOPPED)
        stands = f"a ({endless.pid}), thread 0, computes"
        while stands not in str((found := devices(made))["standstill"]):
            assert endless.poll() is other.poll() is None
        made.hears(f"canwire: {found['standstill']}")
        again = devices(made)
        assert (again["now_ns"], again["programs"]) == (found["now_ns"], found["programs"])
        told = subprocess.run(
            [sys.executable, "-m", "canwire", "devices", "--hub", made.address],
            capture_output=True,
            text=True,
            timeout=LONG_S,
            check=True,
        ).stdout
        assert f"  a ({endless.pid}), thread 0: runs\n  b ({other.pid}), thread 0: waits for 0." in told
        assert f"! {found['standstill']}" in told
        os.kill(endless.pid, signal.SIGCONT)
        other.kill()
        made.hears(f"b ({other.pid}) has left")


LOSES = """
import canwire
try:
    with canwire.connect() as hub:
        print("ready", flush=True)
        while True:  # alone it sleeps as long as it likes in no time
            hub.sleep(1e6)
except canwire.HubLost:
    print("lost", flush=True)
"""


def test_a_program_that_waits_for_its_turn_hears_that_the_hub_is_gone(tmp_path: Path) -> None:
    with bench(tmp_path, "--programs", "1") as made:
        waits = made.start("waits", LOSES)
        assert first_line(waits) == "ready"
        made.kill_hub()
        assert first_line(waits) == "lost"
        assert waits.wait(LONG_S) == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--programs", "2"], "--programs, --patience and --pace are for --time lockstep"),
        (["--time", "lockstep", "--programs", "0"], "'0': a number from 1 up, or different names"),
        (["--time", "lockstep", "--programs", "a,a"], "'a,a': a number from 1 up, or different names"),
        (["--time", "lockstep", "--patience", "0"], "patience_s 0.0: from 0.001"),
    ],
)
def test_words_that_mean_nothing(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status_of("serve", "--socket", str(tmp_path / "hub.sock"), *words) == 2
    assert said in capsys.readouterr().err
