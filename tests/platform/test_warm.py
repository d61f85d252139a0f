"""A program that tests/warm forks is what `python` would have started: words, place, streams, and how it ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests import warm
from tests.hubs import LONG_S

TELL = """
import os, signal, sys
print(__name__, sys.argv, os.getcwd(), os.environ.get("GREETING"), sys.stdin.read(), sys.stdout.encoding)
print(os.getsid(0) == os.getpid(), sorted(os.listdir("/proc/self/fd"))[:-1], file=sys.stderr)
print([signal.getsignal(number) for number in (signal.SIGINT, signal.SIGCHLD, signal.SIGPIPE)])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere every program starts cold")
@pytest.mark.parametrize("ending", ["", "sys.exit(3)", "os._exit(4)", "os.kill(os.getpid(), signal.SIGKILL)"])
@pytest.mark.parametrize("session", [False, True])
def test_warm_is_as_cold(tmp_path: Path, ending: str, session: bool) -> None:
    found = []
    for start in (warm.Popen, subprocess.Popen):
        process = start(
            [sys.executable, "-c", TELL + "sys.stdout.flush()\n" + ending, "a word"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=tmp_path,
            env={**os.environ, "GREETING": "hello"},
            start_new_session=session,
            text=True,
        )
        found.append((process.communicate("what it reads", LONG_S), process.returncode))
    assert found[0] == found[1]
    assert "what it reads" in found[0][0][0]


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere every program starts cold")
def test_a_warm_program_is_killed_and_waited_for() -> None:
    words = [sys.executable, "-c", "print('ready', flush=True); input()"]
    with warm.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        assert process.poll() is None
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.01)
        process.terminate()
        assert process.wait(LONG_S) == process.poll() == -signal.SIGTERM


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere every program starts cold")
def test_who_is_asked_by_a_script_ends_with_it(tmp_path: Path) -> None:
    script = tmp_path / "canwire"
    warm.write_script(script)
    command = [str(script), "serve", "--socket", str(tmp_path / "hub.sock")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert "canwire hub on" in process.stdout.readline()
        process.kill()
        assert process.stdout.read() == ""  # its end: nobody has the other end of the pipe any more


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere every program starts cold")
def test_a_warm_program_has_the_descriptors_it_is_given_and_no_others() -> None:
    found = []
    reading, writing = os.pipe()
    try:
        for start in (warm.Popen, subprocess.Popen):
            words = [sys.executable, "-c", TELL + f"os.write({writing}, b'heard')", "a word"]
            with start(
                words, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, pass_fds=[writing]
            ) as process:
                found.append((process.communicate(timeout=LONG_S), os.read(reading, 80)))
    finally:
        os.close(reading)
        os.close(writing)
    assert found[0] == found[1]
    assert found[0][1] == b"heard"
