"""A limit of time interrupts Python code, and leaves nothing behind in the interpreter."""

from __future__ import annotations

import sys
from types import FrameType
from typing import Any

import pytest

from canwire.platform.time_limit import interrupted_after, time_limit
from tests.hubs import LONG_S


class Late(Exception):
    """What a reader raises."""


def count_without_end() -> None:
    while True:
        pass


def test_what_takes_too_long_is_ended() -> None:
    with pytest.raises(Late), time_limit(0.001, Late):
        count_without_end()


def test_an_error_inside_stays_that_error() -> None:
    with pytest.raises(ValueError, match="own"), time_limit(LONG_S, Late):
        raise ValueError("own")


def test_a_limit_that_was_kept_leaves_the_interpreter_as_it_was() -> None:
    """CPython 3.11 makes no progress under a tracer after an asynchronous exception was taken back."""
    with interrupted_after(LONG_S, KeyboardInterrupt):
        pass
    lines = 0

    def trace(frame: FrameType, event: str, argument: Any) -> Any:
        nonlocal lines
        lines += event == "line"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        total = sum(number for number in range(1000))
    finally:
        sys.settrace(before)
    assert (total, lines > 0) == (499_500, True)
