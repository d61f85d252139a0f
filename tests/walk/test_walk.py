"""A part of the walk over compiled names, a fork for each module; `python -m tests.walk` is all of it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import pytest

import canwire
from tests.walk.attempts import Attempt, Subjects
from tests.walk.child import walked
from tests.walk.names import compiled
from tests.walk.scene import found_in, scene

pytestmark = [
    pytest.mark.skipif(not hasattr(os, "fork") or sys.platform != "linux", reason="it forks"),
    pytest.mark.finding("faults-2 11"),
]
EVERY = 31  # attempts, of which one is made


def in_a_fresh_process(function: str, folder: Path) -> None:
    """Call this function of this file: a walk forks, and here other tests may have left threads that hold locks."""
    code = f"import sys; from {__name__} import {function}; {function}(sys.argv[1])"
    environment = os.environ | {"XDG_RUNTIME_DIR": str(folder)}
    ended = subprocess.run(
        [sys.executable, "-c", code, str(folder)],
        cwd=Path(__file__).parents[2],
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr


@pytest.mark.core
@pytest.mark.skipif(canwire.core_mode() == "uncompiled", reason="Python looks at all of that itself")
def test_no_compiled_name_ends_the_interpreter(tmp_path: Path) -> None:
    in_a_fresh_process("every_compiled_name", tmp_path)


def test_what_it_finds_is_a_row_and_the_rest_goes_on(tmp_path: Path) -> None:
    in_a_fresh_process("each_kind_of_end", tmp_path)


def every_compiled_name(folder: str) -> None:
    """None of a part of all attempts does harm."""
    healthy = found_in(scene())
    wrong, count = [], 0
    for number, name in enumerate(compiled()):

        def some(name: str = name, first: int = number % EVERY) -> Iterator[Attempt]:
            return islice(Subjects(name, healthy, 1).systematic(), first, None, EVERY)

        done = walked(some, folder)
        wrong += done.wrong
        count += done.count
    assert wrong == []
    assert count > 50_000 // EVERY


def each_kind_of_end(folder: str) -> None:
    """Each is a row, and the attempts after it are made."""

    def is_none() -> None:
        raise SystemError("returned NULL")

    def refused() -> None:
        raise TypeError("as it should be")

    def for_ever() -> None:
        signal.setitimer(signal.ITIMER_PROF, 0.01)
        while True:
            pass

    def waits() -> None:
        signal.setitimer(signal.ITIMER_REAL, 0.01)
        signal.pause()

    def of_itself() -> None:
        raise KeyboardInterrupt

    tries = [
        Attempt("crash", lambda: os.kill(os.getpid(), signal.SIGKILL)),
        Attempt("refused", refused),
        Attempt("null", is_none),
        Attempt("hang", for_ever),
        Attempt("wait", waits),
        Attempt("end", lambda: os._exit(3)),
        Attempt("right", int),
        Attempt("interrupt", of_itself),
    ]
    done = walked(lambda: iter(tries), folder)
    assert done.count == len(tries)
    assert done.wrong[0:2] == ["crash: SIGKILL", "null: SystemError: returned NULL"]
    assert len(done.wrong) == 5
    assert done.wrong[-1] == "end: ends the process with status 3"
    assert done.wrong[2:4] == ["hang: takes over 10 s of processor time", "wait: waits over 60 s"]
