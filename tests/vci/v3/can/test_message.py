"""CanMessage and CanCyclicTXMsg: properties over the bits of reference/vci.md section 3."""

from __future__ import annotations

import pytest

from canwire.vci import CanMsg, CanMsgInfo
from canwire.vci.v3 import (
    ArgumentException,
    ArgumentOutOfRangeException,
    CanCyclicTXIncMode,
    CanCyclicTXMsg,
    CanCyclicTXStatus,
    CanMessage,
    CanMsgAccReason,
    CanMsgError,
    CanMsgFrameType,
)
from canwire.vci.v3.can.message import received
from tests.cases import each

FLAGS = [
    ("self_reception_request", 1 << 21),
    ("remote_transmission_request", 1 << 22),
    ("extended_frame_format", 1 << 23),
    ("single_shot_mode", 1 << 8),
    ("high_priority_msg", 1 << 9),
]


def test_a_new_message_is_all_zeros() -> None:
    message = CanMessage()
    assert message.raw == CanMsg()
    assert message.frame_type is CanMsgFrameType.DATA
    assert (message.identifier, message.time_stamp, message.data_length) == (0, 0, 0)


@each(("name", "bit"), FLAGS)
def test_flags(name: str, bit: int) -> None:
    message = CanMessage()
    assert getattr(message, name) is False
    setattr(message, name, True)
    assert message.raw.msg_info.value == bit
    assert getattr(message, name) is True
    setattr(message, name, False)
    assert message.raw.msg_info.value == 0


def test_properties_lie_where_the_structure_has_them() -> None:
    message = CanMessage()
    message.time_stamp = 0x01020304
    message.identifier = 0x123
    message.frame_type = CanMsgFrameType.STATUS
    message.data_length = 8
    message[0], message[7] = 0x11, 0x88
    assert message.raw.to_bytes() == bytes.fromhex("04030201 23010000 03000800 1100000000000088")


def test_what_only_receivers_are_told() -> None:
    message = received(CanMsg(msg_info=CanMsgInfo(ovr=1, afc=2)))
    assert message.possible_overrun is True
    assert message.accept_reason is CanMsgAccReason.FILTER_2
    for name in ("possible_overrun", "accept_reason"):
        with pytest.raises(AttributeError):
            setattr(message, name, 0)


@each(
    ("name", "value"),
    [
        ("data_length", 9),
        ("data_length", -1),
        ("identifier", 1 << 32),
        ("time_stamp", -1),
        ("frame_type", 7),
    ],
)
def test_properties_refuse_what_is_out_of_range(name: str, value: int) -> None:
    message = CanMessage()
    with pytest.raises(ArgumentOutOfRangeException):
        setattr(message, name, value)
    assert message == CanMessage()


@pytest.mark.parametrize("index", [8, -1])
def test_there_are_eight_bytes(index: int) -> None:
    message = CanMessage()
    with pytest.raises(IndexError):
        message[index]
    with pytest.raises(IndexError):
        message[index] = 0
    with pytest.raises(ArgumentException):
        message[0] = 256
    assert list(message) == [0] * 8


def test_clear() -> None:
    message = CanMessage()
    message.identifier, message.extended_frame_format = 0x1FFFFFFF, True
    message.clear()
    assert message == CanMessage()


def test_messages_are_equal_by_value() -> None:
    one, other = CanMessage(), CanMessage()
    one.identifier = other.identifier = 5
    assert one == other
    other.data_length = 1
    assert one != other


def test_repr_shows_the_message() -> None:
    message = CanMessage()
    message.identifier, message.data_length, message[1] = 0x123, 2, 0xAF
    assert repr(message) == "<CanMessage data 0x123 [2] 00 af>"


@each(("number", "error"), [(4, CanMsgError.BIT), (5, CanMsgError.BIT), (8, CanMsgError.OTHER)])
def test_error_messages_carry_the_numbers_of_v3(number: int, error: CanMsgError) -> None:
    message = received(CanMsg(type=CanMsgFrameType.ERROR, data=bytes([number, 4])))
    assert (message[0], message[1]) == (error, 4)


def test_data_are_no_error_numbers() -> None:
    assert received(CanMsg(data=b"\x08"))[0] == 8


# cyclic messages


def test_a_new_cyclic_message_is_on_no_list() -> None:
    message = CanCyclicTXMsg()
    assert message.status is CanCyclicTXStatus.EMPTY
    assert (message.cycle_ticks, message.auto_increment_index) == (0, 0)
    assert message.auto_increment_mode is CanCyclicTXIncMode.NO_INC
    with pytest.raises(AttributeError):
        message.status = CanCyclicTXStatus.BUSY  # type: ignore[misc]


def test_a_cyclic_message_becomes_the_structure() -> None:
    message = CanCyclicTXMsg()
    message.identifier, message.data_length = 0x321, 3
    message[2] = 0xFF
    message.cycle_ticks = 0x0102
    message.auto_increment_mode = CanCyclicTXIncMode.INC_16
    message.auto_increment_index = 1
    assert message.structure().to_bytes() == bytes.fromhex("0201 03 01 21030000 00000300 0000ff0000000000")


@each(
    ("name", "value"),
    [("cycle_ticks", 0x10000), ("auto_increment_mode", 4), ("auto_increment_index", 8)],
)
def test_cyclic_properties_refuse_what_is_out_of_range(name: str, value: int) -> None:
    with pytest.raises(ArgumentOutOfRangeException):
        setattr(CanCyclicTXMsg(), name, value)


def test_two_cyclic_messages_are_two() -> None:
    one, other = CanCyclicTXMsg(), CanCyclicTXMsg()
    assert one != other
    assert len({one, other}) == 2


def test_clear_leaves_a_cyclic_message_on_its_list() -> None:
    message = CanCyclicTXMsg()
    message.cycle_ticks, message.auto_increment_mode = 5, CanCyclicTXIncMode.INC_ID
    message.told(CanCyclicTXStatus.BUSY)
    message.clear()
    assert (message.cycle_ticks, message.auto_increment_mode) == (0, CanCyclicTXIncMode.NO_INC)
    assert message.status is CanCyclicTXStatus.BUSY
