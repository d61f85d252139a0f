"""Ctrl-C ends `canwire record` wherever it comes, also while the recording's own wait holds a lock."""

from __future__ import annotations

import itertools
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from canwire.commands import main
from canwire.commands.logs import record
from tests.hubs import Served, serving

STEPS = 30  # lines of Python: more than a turn of the wait


@contextmanager
def ctrl_c_at(step: int) -> Iterator[list[str]]:
    """Ctrl-C at that line of Python since the recording began, and in what it calls: the name of its function."""
    steps = itertools.count()
    at: list[str] = []

    def begin(frame: FrameType, event: str, argument: Any) -> Any:
        if frame.f_code is not record._until_the_end.__code__:
            return None
        sys.settrace(go_on)
        return go_on

    def go_on(frame: FrameType, event: str, argument: Any) -> Any:
        if event == "line" and next(steps) == step:
            at.append(frame.f_code.co_name)
            signal.raise_signal(signal.SIGINT)
        return go_on

    before = sys.gettrace()
    sys.settrace(begin)
    try:
        yield at
    finally:
        sys.settrace(before)


@pytest.mark.conforms("PC-10")
def test_ctrl_c_at_every_step_ends_a_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(record, "_TURN_S", 0.001)
    with serving(tmp_path, time="real") as served:
        interrupted = {
            name for step in range(STEPS) for name in interrupted_recording(served, tmp_path, step)
        }
    assert {"_until_the_end", "wait"} <= interrupted
    assert capsys.readouterr().err.count("0 lost") == STEPS


def interrupted_recording(served: Served, folder: Path, step: int) -> list[str]:
    with ctrl_c_at(step) as at:
        words = ["record", "can0", str(folder / f"{step}.log"), "--hub", served.address]
        assert main(words) == 0
    return at
