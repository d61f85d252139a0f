"""A result that another thread brings, also to a wait that a signal has ended."""

from __future__ import annotations

import gc
import sys
import threading
from types import FrameType
from typing import Any

import pytest

from canwire.hub.protocol.pending import Pending
from tests.cases import each
from tests.hubs import LONG_S


def test_the_first_to_settle_counts() -> None:
    pending: Pending[int] = Pending()
    with pytest.raises(TimeoutError):
        pending.result(0)
    assert pending.settle(1)
    assert not pending.settle(2)
    assert not pending.fail(ValueError())
    assert (pending.settled, pending.result(), pending.result(0)) == (True, 1, 1)


def test_a_failure_is_raised() -> None:
    pending: Pending[int] = Pending()
    assert pending.fail(ValueError("no"))
    for _ in range(2):
        with pytest.raises(ValueError, match="no"):
            pending.result()


def interrupted_at(step: int, pending: Pending[int]) -> None:
    """Wait for it, and be interrupted at that line of Python, as by Ctrl-C."""
    steps = 0

    def trace(frame: FrameType, event: str, argument: Any) -> Any:
        nonlocal steps
        steps += event == "line"
        if steps > step:
            raise KeyboardInterrupt
        return trace

    before = sys.gettrace()
    gc.disable()  # else it may come in a callback of the collector's, where it is only printed
    sys.settrace(trace)
    try:
        pending.result(0.001)
    except (KeyboardInterrupt, TimeoutError):
        pass
    finally:
        sys.settrace(before)
        gc.enable()


@each("step", range(24))
def test_a_wait_that_was_interrupted_holds_nobody_up(step: int) -> None:
    pending: Pending[int] = Pending()
    interrupted_at(step, pending)
    bringing = threading.Thread(target=pending.settle, args=(7,), daemon=True)
    bringing.start()
    bringing.join(LONG_S / 10)
    assert not bringing.is_alive()
    assert pending.result(LONG_S) == 7
