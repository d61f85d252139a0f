"""Signals that are given together: to whom, in which order, and when."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import canwire
from canwire.hub.owner.held.bells import Bells
from canwire.platform import EventDescriptor
from canwire.ring import Ring

pytestmark = pytest.mark.core


@pytest.fixture
def events() -> Iterator[list[EventDescriptor]]:
    made = [EventDescriptor() for _ in range(3)]
    yield made
    for event in made:
        event.close()


def test_nothing_is_signalled_before_the_bells_are_rung(events: list[EventDescriptor]) -> None:
    bells = Bells()
    first, _, third = (bells.late(event) for event in events)
    third.signal()
    first.signal()
    assert [event.take() for event in events] == [False, False, False]
    bells.ring()
    assert [event.take() for event in events] == [True, False, True]
    bells.ring()
    assert [event.take() for event in events] == [False, False, False]


def test_those_behind_one_that_fails_are_rung_next_time(events: list[EventDescriptor]) -> None:
    class Broken(EventDescriptor):
        def signal(self) -> None:
            raise OSError("broken")

    bells, broken = Bells(), Broken()
    bells.late(broken).signal()
    bells.late(events[0]).signal()
    with pytest.raises(OSError, match="broken"):
        bells.ring()
    bells.ring()
    assert events[0].take()
    broken.close()


def test_a_reader_that_waits_for_one_of_many_records_is_told_once(events: list[EventDescriptor]) -> None:
    bells, memory = Bells(), memoryview(bytearray(4096))
    ring, reader = Ring(16, buffer=memory), Ring(16, buffer=memory)
    ring.event = bells.late(events[0])
    reader.arm()
    for _ in range(5):
        assert ring.put_bytes(bytes(80))
    assert list(bells.due) == [events[0]]
    bells.ring()
    assert events[0].take()
    assert reader.fill() == 5


@pytest.mark.realtime
@pytest.mark.parametrize("time", ["real", "fast"])
def test_every_frame_reaches_a_program_that_waits_for_each(time: str) -> None:
    timing = canwire.BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)
    with canwire.connect(time=time) as hub:
        board = hub.boards()[0].id
        for line in (0, 1):
            control = hub.open_control(board, line)
            control.initialise(canwire.LineMode(timing))
            control.start()
        sender, receiver = hub.open_channel(board, 0), hub.open_channel(board, 1)
        sender.set_up(canwire.ChannelMode(1, 256, frames=False))
        receiver.set_up(canwire.ChannelMode(256, 0))
        for channel in (sender, receiver):
            channel.activate()
        for number in range(200):
            sender.send(canwire.Frame(0x100, bytes([number])), timeout=10)
            if number % 3 == 0:
                frame = receiver.receive(10)
                assert frame is not None
                assert frame.data[0] == number // 3
        rest = receiver.receive_many(200, 10)
        while len(rest) < 200 - 67:
            more = receiver.receive_many(200, 10)
            assert more
            rest += more
        assert [frame.data[0] for frame in rest] == list(range(67, 200))
