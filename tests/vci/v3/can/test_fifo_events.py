"""Thresholds, events and locks of readers and writers."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from canwire.vci import v3
from tests.vci.v3.programs import NetProgram

LONG_MS = 30_000


@pytest.mark.conforms("X3-22")
def test_the_reader_s_event_comes_with_the_threshold(online: NetProgram, message: Any) -> None:
    sender, other, receiver = online.port(0), online.port(1), online.port(1)
    receiver.waiting(None)
    other.waiting(None)
    receiver.reader.threshold = 3
    receiver.event.reset()
    for number in range(2):
        sender.send(message(number))
        other.receive()
        assert not receiver.event.is_set()
    sender.send(message(2))
    assert receiver.event.wait_one(LONG_MS)
    assert receiver.reader.fill_count == 3


@pytest.mark.conforms("X3-22")
def test_the_writer_s_event_comes_when_there_is_room(online: NetProgram, message: Any) -> None:
    control = online.open(v3.CanControl, 0, "HW000002")
    control.init_line(v3.CanOperatingModes.STANDARD, v3.CanBitrate.CIA_500_KBIT)
    port = online.port(0, "HW000002")
    writer = port.writer
    writer.send_messages([message(1)] * writer.capacity)
    event = v3.ManualResetEvent()
    writer.threshold = 150
    writer.assign_event(event)
    assert not event.is_set()
    control.start_line()
    assert event.wait_one(LONG_MS)
    assert writer.free_count >= 150
    writer.assign_event(None)
    event.close()


def test_thresholds_are_limited_to_the_capacity(net: NetProgram) -> None:
    for end in (net.port().reader, net.port().writer):
        assert end.threshold == 1
        end.threshold = 0
        assert end.threshold == 1
        end.threshold = 65_535
        assert end.threshold == end.capacity
        with pytest.raises(v3.ArgumentOutOfRangeException):
            end.threshold = 65_536


def test_a_plain_event_serves_as_well(online: NetProgram, message: Any, event: Any) -> None:
    sender, receiver = online.port(0), online.port(1)
    receiver.waiting(None)
    receiver.reader.assign_event(event)
    sender.send(message(1))
    assert event.wait(LONG_MS / 1000)
    receiver.reader.assign_event(None)


def test_lock_keeps_another_thread_out(net: NetProgram) -> None:
    port = net.port()
    order = []

    def work() -> None:
        port.reader.lock()
        order.append("other")
        port.reader.unlock()

    port.reader.lock()
    thread = threading.Thread(target=work)
    thread.start()
    order.append("first")
    port.reader.unlock()
    thread.join(LONG_MS / 1000)
    assert order == ["first", "other"]
    with pytest.raises(v3.VciException):
        port.reader.unlock()
