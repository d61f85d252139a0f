"""A node's time may leave out some frames; all others are sent."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import Any

import pytest

from canwire import BitTiming, Frame
from canwire.boards.can.channel import Channel
from canwire.boards.can.sending import Sending
from canwire.boards.catalogue import ideal_line, plug
from canwire.bus.can.bus import CanBus
from canwire.drivers.driver import LineSettings
from canwire.timeline import Timeline

pytestmark = pytest.mark.core


class Time:
    """Virtual time with a selection, if there is one."""

    pacer: object = None

    def __init__(self, selection: object) -> None:
        self.selection = selection
        self.waiters: dict[Any, int] = {}

    def touch(self) -> AbstractContextManager[None]:
        return nullcontext()

    def active(self) -> None:
        """Nobody waits."""


class WithoutOne(Sending):
    """Leaves out identifier 1, where a selection asks for that."""

    def _takes(self, frame: Frame) -> bool:
        return frame.id != 1


@pytest.mark.parametrize(("selection", "sent"), [(None, [True, True]), (object(), [False, True])])
def test_a_selection_leaves_out_frames(selection: object, sent: list[bool]) -> None:
    found = []
    for id in (1, 2):
        timeline = Timeline()
        line = ideal_line("line", timeline)
        plug(line, CanBus(timeline))
        line.driver.configure(LineSettings(BitTiming.for_bit_rate(500_000, clock_hz=80_000_000), None))
        line.driver.start(0, integrated=True)
        sending = WithoutOne(Time(selection), line, line.open(Channel(16, 16)), False)
        sending.send(Frame(id))
        found.append(line.controller.normal.occupied != 0)
    assert found == sent
