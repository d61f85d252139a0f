"""Messages through channels: what arrives, what is refused, and in which order."""

from __future__ import annotations

import itertools
from typing import Any

import pytest

from canwire.vci import v3
from tests.vci.v3.programs import NetProgram

LONG_MS = 30_000
DATA = v3.CanMsgFrameType.DATA
DELAY_TICK_US = 100


def ids(messages: list[v3.CanMessage]) -> list[int]:
    return [one.identifier for one in messages]


@pytest.mark.conforms("X3-19", "X3-20")
def test_messages_go_from_line_to_line(online: NetProgram, message: Any) -> None:
    sender, receiver = online.port(0), online.port(1)
    sender.send(
        message(0x123, b"hello"),
        message(0x18DAF110, b"\x01", extended_frame_format=True),
        message(0x7, b"", remote_transmission_request=True, data_length=3),
    )
    first, second, third = receiver.receive(3)
    assert (first.identifier, first.data_length, bytes(first)) == (0x123, 5, b"hello\0\0\0")
    assert (second.identifier, second.extended_frame_format, second[0]) == (0x18DAF110, True, 1)
    assert (third.identifier, third.remote_transmission_request, third.data_length) == (7, True, 3)
    assert first.time_stamp < second.time_stamp < third.time_stamp
    assert first.accept_reason is v3.CanMsgAccReason.FILTER_1
    assert not first.self_reception_request
    assert sender.waiting() == []


@pytest.mark.conforms("X3-19")
def test_an_inactive_channel_gets_nothing_and_never_will(online: NetProgram, message: Any) -> None:
    sender, awake, asleep = online.port(0), online.port(1), online.port(1, active=False)
    sender.send(message(1))
    awake.receive()
    asleep.channel.activate()
    sender.send(message(2))
    assert ids(asleep.receive()) == [2]
    asleep.channel.deactivate()
    sender.send(message(3))
    assert ids(awake.receive(2)) == [2, 3]
    assert asleep.waiting() == []


@pytest.mark.conforms("X3-19")
def test_a_stopped_line_gets_nothing_and_never_will(online: NetProgram, message: Any) -> None:
    control = online.open(v3.CanControl, 1, "HW000002")
    control.init_line(v3.CanOperatingModes.STANDARD, v3.CanBitrate.CIA_500_KBIT)
    sender, listener, deaf = online.port(0), online.port(1), online.port(1, "HW000002")
    sender.send(message(1))
    listener.receive()
    control.start_line()
    sender.send(message(2))
    assert ids(deaf.receive()) == [2]


@pytest.mark.conforms("X3-19")
def test_messages_leave_once_channel_and_line_are_ready(net: NetProgram, message: Any) -> None:
    net.start(1)
    sender, receiver = net.port(0, active=False), net.port(1)
    sender.send(message(1))
    control = net.start(0)
    other = net.port(0)
    other.send(message(2))
    assert ids(receiver.receive()) == [2]
    sender.channel.activate()
    assert ids(receiver.receive()) == [1]
    control.stop_line()
    sender.send(message(3))
    assert receiver.waiting() == []
    control.start_line()
    assert ids(receiver.receive()) == [3]


@pytest.mark.conforms("X3-20")
def test_send_messages_tells_how_many_fitted(net: NetProgram, message: Any) -> None:
    port = net.port(tx=5)
    room = port.writer.capacity
    assert room >= 5
    assert port.writer.free_count == room
    assert port.writer.send_messages([message(one) for one in range(room + 7)]) == room
    assert port.writer.free_count == 0
    assert port.writer.send_message(message(0)) is False
    assert port.writer.send_messages([message(0)]) == 0
    assert port.writer.send_messages([]) == 0
    assert port.channel.channel_status.transmit_fifo_load == 100


@pytest.mark.conforms("X3-20")
def test_read_messages_tells_how_many_there_were(online: NetProgram, message: Any) -> None:
    sender, receiver = online.port(0), online.port(1)
    receiver.waiting(None)
    receiver.reader.threshold = 5
    sender.send(*[message(one) for one in range(5)])
    assert receiver.event.wait_one(LONG_MS)
    assert receiver.reader.fill_count == 5
    array: list[Any] = [None] * 3
    assert receiver.reader.read_messages(array) == 3
    assert ids(array) == [0, 1, 2]
    array = [None] * 3
    assert receiver.reader.read_messages(array) == 2
    assert ids(array[:2]) == [3, 4]
    assert array[2] is None
    assert receiver.reader.read_messages(array) == 0
    assert receiver.reader.read_messages(3) == []
    assert receiver.reader.read_message() is None


@pytest.mark.conforms("X3-20")
def test_reading_goes_on_where_the_fifo_s_memory_ends(online: NetProgram, message: Any) -> None:
    sender, receiver = online.port(0), online.port(1, rx=100)
    receiver.waiting(None)
    capacity = receiver.reader.capacity
    for _ in range(3):
        count = capacity * 3 // 4
        receiver.reader.threshold = count
        sender.send(*[message(one) for one in range(count)])
        assert receiver.event.wait_one(LONG_MS)
        assert ids(receiver.reader.read_messages(capacity)) == list(range(count))


def test_read_message_fills_the_one_it_is_given(online: NetProgram, message: Any) -> None:
    sender, receiver = online.port(0), online.port(1)
    receiver.waiting(None)
    out = v3.CanMessage()
    assert receiver.reader.read_message(out) is False
    sender.send(message(0x321, b"\x07"))
    assert receiver.event.wait_one(LONG_MS)
    assert receiver.reader.read_message(out=out) is True
    assert (out.identifier, out[0]) == (0x321, 7)


@pytest.mark.parametrize("what", [None, b"\0" * 20, "message"])
def test_only_messages_are_sent(net: NetProgram, what: Any) -> None:
    with pytest.raises(v3.ArgumentException):
        net.port().writer.send_message(what)


@pytest.mark.conforms("X3-23")
def test_other_types_than_data_are_dropped_and_counted(online: NetProgram, message: Any) -> None:
    sender, receiver = online.port(0), online.port(1)
    before = online.status(0).refused
    others = [kind for kind in v3.CanMsgFrameType if kind is not DATA]
    sender.send(*[message(1, frame_type=kind) for kind in others], message(2))
    assert ids(receiver.receive()) == [2]
    assert online.status(0).refused - before == len(others)


@pytest.mark.conforms("X3-15")
def test_stop_and_reset_leave_the_fifos_as_they_are(net: NetProgram, message: Any) -> None:
    net.start(0)
    control = net.start(1)
    sender, receiver = net.port(0), net.port(1)
    receiver.waiting(None)
    receiver.reader.threshold = 2
    sender.send(message(1), message(2))
    assert receiver.event.wait_one(LONG_MS)
    control.stop_line()
    receiver.writer.send_message(message(3))
    control.reset_line()
    assert ids(receiver.waiting()) == [1, 2]
    control.start_line()
    assert ids(sender.receive()) == [3]


@pytest.mark.conforms("X3-18")
def test_channels_take_turns(net: NetProgram, message: Any) -> None:
    net.start(1)
    receiver = net.port(1)
    senders = [net.port(0) for _ in range(3)]
    for number, sender in enumerate(senders):
        sender.send(*[message(number) for _ in range(40)])
    net.start(0)
    heard = ids(receiver.receive(120))
    for end in range(1, 121):
        shares = [heard[:end].count(number) for number in range(3)]
        assert max(shares) - min(shares) <= 1


@pytest.mark.conforms("X3-24")
def test_self_reception_comes_after_sending_and_past_the_filter(net: NetProgram, message: Any) -> None:
    control = net.control(0)
    for select in v3.CanFilter:
        control.set_acc_filter(select, v3.CanAccCode.NONE, v3.CanAccMask.NONE)
    control.start_line()
    sender, sibling = net.port(0), net.port(0)
    sender.send(message(0x55, b"\x01", self_reception_request=True))
    assert sender.waiting() == []  # nobody acknowledges it
    net.start(1)
    for port in (sender, sibling):
        (back,) = port.receive()
        assert (back.identifier, back[0], back.self_reception_request) == (0x55, 1, True)
        assert back.accept_reason is v3.CanMsgAccReason.ALWAYS


@pytest.mark.conforms("X3-25")
def test_delayed_messages_keep_their_distance(net: NetProgram, message: Any) -> None:
    net.start(1)
    control, sender, receiver = net.control(0), net.port(0), net.port(1)
    delays = [0, 10, 25, 0, 300]
    sender.send(*[message(1, time_stamp=ticks) for ticks in delays])
    control.start_line()
    stamps = [one.time_stamp for one in receiver.receive(len(delays))]
    gaps_us = [after - before for before, after in itertools.pairwise(stamps)]
    for gap_us, ticks in zip(gaps_us, delays[1:], strict=True):
        assert ticks * DELAY_TICK_US <= gap_us <= ticks * DELAY_TICK_US + 200


@pytest.mark.conforms("X3-25")
def test_longer_delays_than_there_are_are_refused(online: NetProgram, message: Any) -> None:
    sender, receiver = online.port(0), online.port(1)
    before = online.status(0).refused
    longest = sender.channel.max_delayed_tx_ticks
    sender.send(message(1, time_stamp=longest + 1), message(2))
    assert ids(receiver.receive()) == [2]
    assert online.status(0).refused - before == 1


def test_an_overrun_marks_the_next_message_and_the_status(online: NetProgram, message: Any) -> None:
    sender, small, large = online.port(0), online.port(1, rx=1), online.port(1, rx=1000)
    room = small.reader.capacity
    assert not small.channel.channel_status.has_fifo_overrun
    for _ in range(4):
        sender.send(*[message(1) for _ in range(room // 2)])
        large.receive(room // 2)
    assert small.channel.channel_status.has_fifo_overrun
    assert small.channel.channel_status.receive_fifo_load == 100
    assert not any(one.possible_overrun for one in small.waiting())
    sender.send(message(2), message(3))
    assert [one.possible_overrun for one in small.receive(2)] == [True, False]
