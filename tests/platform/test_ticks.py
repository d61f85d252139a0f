"""Windows' clock ticks every 15.6 ms: no frame waits for a time to pass where a signal can end the wait."""

from __future__ import annotations

import select
import selectors
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import ChannelMode, Frame, WantedMode
from canwire.platform import PORTABLE
from canwire.ring import RECHECK_S
from tests.hubs import LONG_S, served_here

pytestmark = pytest.mark.skipif(not PORTABLE, reason="epoll's waits cannot be counted from Python")
FRAMES = 50


@pytest.fixture
def waited(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[list[float | None], list[float]]]:
    """The timeouts of all waits of this process, hub and program alike, and of those that nothing else ended.

    An uncompiled ring looks anew every 10 ms (RECHECK_S), which ends a wait where the other side takes longer.
    """
    every: list[float | None] = []
    over: list[float] = []

    def counted(which: Any) -> Any:
        def wait(*words: Any) -> Any:
            found = which(*words)
            every.append(words[-1])
            if words[-1] not in (None, 0, RECHECK_S) and not (
                any(found) if isinstance(found, tuple) else found
            ):
                over.append(words[-1])
            return found

        return wait

    monkeypatch.setattr(select, "select", counted(select.select))
    monkeypatch.setattr(selectors.SelectSelector, "select", counted(selectors.SelectSelector.select))
    return every, over


@pytest.mark.conforms("G-20")
def test_frames_to_and_fro_end_no_wait_by_its_timeout(
    tmp_path: Path, waited: tuple[list[float | None], list[float]]
) -> None:
    every, over = waited
    with ExitStack() as held:
        address = held.enter_context(served_here(tmp_path))
        hub = held.enter_context(closing(canwire.connect(address)))
        lines = canwire.find_lines(hub, "can0")[:2]
        for line in lines:
            held.enter_context(
                canwire.start_line(hub, line, WantedMode(500_000).mode(line.info.capabilities))
            )
        one, other = (hub.open_channel(line.board.id, line.line) for line in lines)
        for channel in (one, other):
            channel.set_up(ChannelMode(receive=8, transmit=8))
            channel.activate()
        for number in range(1 + FRAMES):
            for sender, receiver in ((one, other), (other, one)):
                sender.send(Frame(0x100, bytes([number])), timeout=LONG_S)
                assert receiver.receive(LONG_S) == Frame(0x100, bytes([number]))
            if number == 0:  # the lines' start has to wait for 11 recessive bits
                every.clear()
                over.clear()
        waits = len(every), list(over)
    assert waits[0] >= FRAMES
    assert waits[1] == []
