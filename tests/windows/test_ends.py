"""Ctrl-C and Ctrl-Break in a console of Windows end a verb as its page says."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.windows.conftest import Console, Windows

CTRL_C = b"\x03"


@pytest.fixture
def console(windows: Windows) -> Iterator[Callable[..., Console]]:
    """`canwire WORDS` in a console of its own."""
    made: list[Console] = []

    def start(*words: str) -> Console:
        made.append(Console("-m", "canwire", *words))
        return made[-1]

    yield start
    for each in made:
        each.close()


def test_ctrl_c_ends_a_hub_and_what_listens_there(
    windows: Windows, console: Callable[..., Console], tmp_path: Path
) -> None:
    address = windows.path(tmp_path / "hub")
    hub = console("serve", "--time", "fast", "--socket", address)
    hub.wait_for("canwire hub on")
    windows.done("up", "HW000002:0", "--hub", address)
    log = tmp_path / "a log.asc"
    record = console("record", "HW000002:0", windows.path(log), "--hub", address)
    gen = console("gen", "HW000001:0", "--hub", address)
    gen.wait_for("onto HW000001:0")
    dump = console("dump", "HW000002:0", "--hub", address)
    dump.wait_for("can0")
    while not log.exists() or log.stat().st_size < 1000:  # the head, and some frames
        windows.canwire("send", "HW000001:1", "123#1122", "--hub", address)
    for listening in (dump, record, gen):
        listening.type(CTRL_C)
        assert listening.end() in (0, 130)
    assert "frames" in windows.canwire("stats", windows.path(log))
    hub.type(CTRL_C)
    assert hub.end() == 0
    assert not (tmp_path / "hub").exists()
