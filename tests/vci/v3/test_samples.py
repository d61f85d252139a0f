"""The manual's C# samples (4.2.3.1, 4.2.3.2 and 4.2.4.1), in Python."""

from __future__ import annotations

from typing import Any

import pytest

from canwire.vci.v3 import (
    CanBitrate,
    CanMessage,
    CanMsgFrameType,
    CanOperatingModes,
    CanScheduler,
    ICanControl,
    ICanMessageReader,
    ICanMessageWriter,
)
from tests.vci.v3.programs import NetProgram

LONG_MS = 30_000


def do_messages(reader: ICanMessageReader) -> list[CanMessage]:
    processed = []
    while (message := reader.read_message()) is not None:
        processed.append(message)
    return processed


def do_messages_with_out(reader: ICanMessageReader) -> list[int]:
    processed = []
    message = CanMessage()
    while reader.read_message(out=message):
        processed.append(message.identifier)
    return processed


def do_messages_many(reader: ICanMessageReader) -> list[CanMessage]:
    messages: list[Any] = [None] * 10
    read_count = reader.read_messages(messages)
    return [messages[i] for i in range(read_count)]


def send_message(writer: ICanMessageWriter, identifier: int, data: int) -> bool:
    message = CanMessage()
    message.time_stamp = 0
    message.identifier = identifier
    message.frame_type = CanMsgFrameType.DATA
    message.self_reception_request = False
    message.extended_frame_format = False
    message.data_length = 1
    message[0] = data
    return writer.send_message(message)


def send(writer: ICanMessageWriter) -> bool:
    messages = [CanMessage() for _ in range(3)]
    messages[0].identifier = 0x100
    messages[0].data_length = 0
    messages[1].identifier = 0x200
    messages[1].data_length = 3
    messages[1].remote_transmission_request = True
    messages[2].identifier = 0x300
    messages[2].data_length = 2
    messages[2][0] = 0x01
    messages[2][1] = 0xAF
    return len(messages) == writer.send_messages(messages)


def auto_init_line(control: ICanControl) -> None:
    index = control.detect_baud(10_000, CanBitrate.CIA_BIT_RATES)
    if index > -1:
        mode = CanOperatingModes.STANDARD | CanOperatingModes.ERR_FRAME
        control.init_line(mode, CanBitrate.CIA_BIT_RATES[index])


@pytest.fixture
def ends(net: NetProgram) -> Any:
    """A writer on one line, a reader on the other, and a way to wait until so many messages are there."""
    net.start(0)
    net.start(1)
    sender, receiver = net.port(0), net.port(1)
    receiver.waiting(None)

    def wait(count: int) -> None:
        receiver.reader.threshold = count
        while receiver.reader.fill_count < count:  # the event may stand for what came before this threshold
            assert receiver.event.wait_one(LONG_MS)

    return sender.writer, receiver.reader, wait


@pytest.mark.smoke
@pytest.mark.conforms("X3-20")
def test_single_messages(ends: Any) -> None:
    writer, reader, wait = ends
    assert send_message(writer, 0x123, 0x45)
    wait(1)
    (message,) = do_messages(reader)
    assert (message.identifier, message.data_length, message[0]) == (0x123, 1, 0x45)


@pytest.mark.conforms("X3-20")
def test_many_messages(ends: Any) -> None:
    writer, reader, wait = ends
    assert send(writer)
    wait(3)
    empty, remote, data = do_messages_many(reader)
    assert (empty.identifier, empty.data_length) == (0x100, 0)
    assert (remote.identifier, remote.data_length, remote.remote_transmission_request) == (0x200, 3, True)
    assert (data.identifier, data[0], data[1]) == (0x300, 0x01, 0xAF)


def test_out_parameters(ends: Any) -> None:
    writer, reader, wait = ends
    assert send(writer)
    wait(3)
    assert do_messages_with_out(reader) == [0x100, 0x200, 0x300]


@pytest.mark.conforms("X3-20")
def test_the_names_of_the_manual_s_text(ends: Any) -> None:
    writer, reader, wait = ends
    assert writer.write_messages([CanMessage(), CanMessage()]) == 2
    assert writer.write_message(CanMessage())
    wait(3)
    assert reader.get_message() is not None
    assert len(reader.get_messages(10)) == 2


@pytest.mark.conforms("X3-12")
def test_auto_init_line(net: NetProgram, cyclic: Any) -> None:
    for port, board in ((1, "HW000001"), (1, "HW000002")):
        net.start(port, board, bitrate=CanBitrate.CIA_250_KBIT)
    scheduler = net.open(CanScheduler, 1)
    heartbeat = cyclic(0x701, b"\x05", cycle_ticks=100)
    scheduler.add_message(heartbeat)
    scheduler.start_message(heartbeat)
    scheduler.resume()
    control = net.open(ICanControl)
    auto_init_line(control)
    status = control.line_status
    assert status.bitrate == CanBitrate.CIA_250_KBIT
    assert status.operating_mode == CanOperatingModes.STANDARD | CanOperatingModes.ERR_FRAME
    assert status.is_in_init_mode
    control.start_line()
    port = net.port()
    assert port.receive()[0].identifier == 0x701
