"""A time limit ends what runs in its thread, and leaves the interpreter as it was."""

from __future__ import annotations

import subprocess
import sys

LATE = """
import sys, time
from canwire.campaigns.limit import TooLong, at_most

def late(work, limit_s):
    try:
        with at_most(limit_s):
            work()
    except TooLong:
        return True
    return False

def swallowed():
    try:
        while True:
            pass
    except BaseException:
        pass

def asleep():
    while True:
        time.sleep(0.01)

assert late(asleep, 0.01)
assert late(swallowed, 0.01)
assert not late(lambda: None, 60)
sys.setprofile(lambda *step: None)
print(sum(1 for _ in range(3)))
"""


def test_an_interpreter_that_was_interrupted_goes_on_under_a_profiler() -> None:
    """CPython 3.11 goes round in a circle there if an exception for a thread was taken back."""
    done = subprocess.run(
        [sys.executable, "-c", LATE], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "3\n", "")
