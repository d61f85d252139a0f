"""A lock that a signal never leaves taken."""

from __future__ import annotations

import _thread
import signal
import threading

import pytest

import canwire
from canwire import Lab
from canwire.holding import Hold
from canwire.pacing import Pacer
from canwire.timeline import Timeline

compiled_only = pytest.mark.skipif(
    canwire.core_mode() == "uncompiled", reason="Python's own functions can be interrupted there"
)


class Press:
    """`Press()[number]` sends this signal; unlike a call, it leaves no moment to Python for handling it."""

    __getitem__ = _thread.interrupt_main


@compiled_only
@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_as_the_lock_is_given_back() -> None:
    """`canwire play --time real` did not end: contextlib's exit was interrupted before it gave the lock back."""
    pacer = Pacer(Timeline())
    with pytest.raises(KeyboardInterrupt) as caught, pacer.holding():
        Press()[signal.SIGINT]
    assert caught.tb is not None  # it still knows the frames that it came through
    assert not pacer._lock._is_owned()
    pacer.close()


@compiled_only
@pytest.mark.realtime
@pytest.mark.usefixtures("ctrl_c")
def test_a_lab_ends_after_ctrl_c_anywhere() -> None:
    with Lab(time="real") as lab:
        lab.can_bus("can0").node("a")
        with pytest.raises(KeyboardInterrupt) as caught, lab.touch():
            Press()[signal.SIGINT]
    assert caught.tb is not None


def test_what_is_entered_and_left_has_the_lock() -> None:
    lock, asked, calls = threading.RLock(), set[Hold](), []

    def call(name: str) -> None:
        calls.append((name, lock._is_owned(), len(asked)))

    with Hold(lock, asked, entered=lambda: call("entered"), leaving=lambda: call("leaving")):
        call("inside")
    assert calls == [("entered", True, 0), ("inside", True, 0), ("leaving", True, 0)]


@pytest.mark.parametrize("where", ["entered", "leaving"])
def test_an_error_there_gives_the_lock_back(where: str) -> None:
    lock, asked = threading.RLock(), set[Hold]()
    with pytest.raises(ZeroDivisionError), Hold(lock, asked, **{where: lambda: 1 // 0}):
        assert where == "leaving"
    assert not lock._is_owned()
