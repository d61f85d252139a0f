"""Windows' clock ticks every 15.6 ms: no frame waits for a time to pass where a signal can end the wait."""

from __future__ import annotations

import select
import selectors
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


class Waits:
    """All waits of this process, hub and program alike; once `lengthened`, no time that passes ends one of them.

    An uncompiled ring looks anew every 10 ms (RECHECK_S), which ends a wait where the other side takes longer.
    """

    def __init__(self) -> None:
        self.lengthened = False
        self.count = 0

    def watched(self, wait: Any) -> Any:
        """The same wait, counted, and lengthened from the moment on when this was asked for."""

        def longer(*words: Any) -> Any:
            *sources, timeout_s = words
            if not self.lengthened:
                return wait(*words)
            self.count += 1
            return wait(*sources, timeout_s if timeout_s in (None, 0, RECHECK_S) else max(timeout_s, LONG_S))

        return longer


@pytest.fixture
def waits(monkeypatch: pytest.MonkeyPatch) -> Waits:
    waits = Waits()
    monkeypatch.setattr(select, "select", waits.watched(select.select))
    monkeypatch.setattr(selectors.SelectSelector, "select", waits.watched(selectors.SelectSelector.select))
    return waits


@pytest.mark.conforms("G-20")
def test_frames_to_and_fro_need_no_wait_to_end_by_its_timeout(tmp_path: Path, waits: Waits) -> None:
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
            waits.lengthened = (
                number < FRAMES
            )  # not before: the lines' start has to wait for 11 recessive bits
    assert waits.count >= FRAMES
