"""A signal that does not interrupt a verb's wait ends it all the same: one that comes in the moment before it."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests import warm

AGES = 60.0

DEAF = """
import select, signal, sys, threading
import canwire.commands

def wait(*arguments):
    if arguments[-1] is None and threading.current_thread() is threading.main_thread():
        print("asleep", file=sys.stderr, flush=True)
    return real(*arguments)

real, select.select = select.select, wait
idle = threading.Event()
threading.Thread(target=idle.wait, daemon=True).start()
numbers = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
signal.pthread_sigmask(signal.SIG_BLOCK, numbers)  # the thread hears them: nothing ends the main one's wait
sys.exit(canwire.commands.main(sys.argv[1:]))
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("words", ["serve --socket s", "dump can0", "lin dump lin0"])
def test_a_signal_just_before_the_wait(
    hub_address: str, tmp_path: Path, words: str, number: signal.Signals
) -> None:
    asked = words.split() if words.startswith("serve") else [*words.split(), "--hub", hub_address]
    command = [sys.executable, "-c", DEAF, *asked]
    with warm.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    ) as verb:
        assert verb.stderr is not None
        assert "asleep\n" in iter(verb.stderr.readline, "")
        verb.send_signal(number)
        try:
            assert verb.wait(AGES) == (0 if words.startswith("serve") else 128 + number)
        finally:
            verb.kill()
