"""V3's LIN values: numbers of reference/vci.md section 4, in the spelling of sections 7a and 9."""

from __future__ import annotations

import dataclasses
from enum import Enum

import pytest

from canwire import vci
from canwire.vci import LinMsg, LinMsgInfo, v3
from canwire.vci.v3 import ArgumentException, ArgumentOutOfRangeException, LinBitrate, LinInitLine, LinMessage
from canwire.vci.v3.lin.message import received
from tests.cases import each

ENUMS: dict[type[Enum], dict[str, int]] = {
    v3.LinOperatingModes: {"SLAVE": 0, "MASTER": 1, "ERRORS": 2},
    v3.LinFeatures: {
        "MASTER": 1,
        "AUTORATE": 2,
        "ERR_FRAME": 4,
        "BUSLOAD": 8,
        "SLEEP": 0x10,
        "WAKEUP": 0x20,
    },
    v3.LinCtrlStatus: {"OVERRUN": 0x01, "IN_INIT": 0x10},
    v3.LinMessageType: {
        "DATA": 0,
        "INFO": 1,
        "ERROR": 2,
        "STATUS": 3,
        "WAKEUP": 4,
        "SLEEP": 5,
        "TIME_OVERRUN": 6,
    },
    v3.LinMsgInfoValue: {"START": 1, "STOP": 2, "RESET": 3},
    v3.LinMsgError: {
        "BIT": 1,
        "CRC": 2,
        "PARITY": 3,
        "SLAVE_NO_RESPONSE": 4,
        "SYNC": 5,
        "NO_BUS": 6,
        "OTHER": 7,
    },
}
RATES = [1000, 1200, 2400, 4800, 9600, 10400, 19200, 20000]


# enumerations


@each("kind", ENUMS, ids=lambda kind: kind.__name__)
def test_members(kind: type[Enum]) -> None:
    assert {name: member.value for name, member in kind.__members__.items()} == ENUMS[kind]


def test_errors_that_v3_does_not_know_are_other() -> None:
    assert v3.LinMsgError(vci.LIN_ERROR_WAKEUP) is v3.LinMsgError.OTHER
    assert v3.LinMsgError(0) is v3.LinMsgError.OTHER


# bit rates


@each("rate", RATES)
def test_predefined_rates(rate: int) -> None:
    made: LinBitrate = getattr(LinBitrate, f"LIN_{rate}_BIT")
    assert made.as_uint16 == rate
    assert made.name == str(made) == f"{rate} bit/s"
    assert made == LinBitrate(rate)


@each(
    ("made", "value", "name"),
    [
        (LinBitrate.UNDEFINED, 65535, "Undefined"),
        (LinBitrate.AUTO_RATE, 0, "Automatic"),
        (LinBitrate.MIN_BITRATE, 1000, "Lowest"),
        (LinBitrate.MAX_BITRATE, 20000, "Highest"),
    ],
)
def test_special_rates(made: LinBitrate, value: int, name: str) -> None:
    assert (made.as_uint16, made.name) == (value, name)


def test_names_do_not_count() -> None:
    assert LinBitrate(10417, "J2602").name == "J2602"
    assert LinBitrate(10417, "J2602") == LinBitrate(10417)
    assert LinBitrate.MIN_BITRATE == LinBitrate.LIN_1000_BIT
    assert LinBitrate(0).name == "Automatic"


@each("rate", [-1, 65536, 9600.0])
def test_a_rate_has_16_bits(rate: int) -> None:
    with pytest.raises(ArgumentOutOfRangeException):
        LinBitrate(rate)


def test_a_rate_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        LinBitrate.LIN_9600_BIT.as_uint16 = 1  # type: ignore[misc]


# how a line is set up


def test_init_line_becomes_the_structure() -> None:
    line = LinInitLine()
    assert line.structure() == vci.LinInitLine()
    line.operating_mode = v3.LinOperatingModes.MASTER | v3.LinOperatingModes.ERRORS
    line.bitrate = LinBitrate.LIN_19200_BIT
    assert line.structure() == vci.LinInitLine(op_mode=3, bitrate=19200)
    assert LinInitLine(v3.LinOperatingModes.SLAVE, LinBitrate(4321)).structure().bitrate == 4321


def test_init_line_refuses_what_is_no_mode_or_rate() -> None:
    with pytest.raises(ArgumentOutOfRangeException, match="operating_mode"):
        LinInitLine(v3.LinOperatingModes(4)).structure()
    with pytest.raises(ArgumentException, match="bitrate 19200"):
        LinInitLine(bitrate=19200).structure()  # type: ignore[arg-type]


# status


def test_line_status() -> None:
    made = v3.LinLineStatus.of(
        vci.LinLineStatus(op_mode=vci.LIN_OPMODE_MASTER, bus_load=25, bitrate=9600, status=0x01)
    )
    assert (made.operating_mode, made.bitrate, made.busload) == (1, LinBitrate.LIN_9600_BIT, 25)
    assert made.controller_status is v3.LinCtrlStatus.OVERRUN
    assert (made.is_in_master_mode, made.is_in_slave_mode, made.is_err_mode_enabled) == (True, False, False)
    assert (made.has_data_overrun, made.is_in_init_mode) == (True, False)


def test_line_status_of_a_stopped_slave() -> None:
    made = v3.LinLineStatus.of(
        vci.LinLineStatus(op_mode=vci.LIN_OPMODE_ERRORS, status=vci.LIN_STATUS_ININIT | vci.LIN_STATUS_ERRLIM)
    )
    assert (made.is_in_master_mode, made.is_in_slave_mode, made.is_err_mode_enabled) == (False, True, True)
    assert (made.has_data_overrun, made.is_in_init_mode) == (False, True)
    assert made.controller_status == 0x14


def test_monitor_status() -> None:
    made = v3.LinMonitorStatus.of(vci.LinMonitorStatus(activated=True, rx_fifo_load=50))
    assert (made.is_activated, made.has_fifo_overrun, made.receive_fifo_load) == (True, False, 50)


# messages


def test_a_new_message_is_all_zeros() -> None:
    message = LinMessage()
    assert message.raw == LinMsg()
    assert message.message_type is v3.LinMessageType.DATA
    assert (message.prot_id, message.time_stamp, message.data_length) == (0, 0, 0)


@each(("name", "bit"), [("extended_crc", 1 << 24), ("sender_of_response", 1 << 25), ("id_only", 1 << 27)])
def test_flags(name: str, bit: int) -> None:
    message = LinMessage()
    assert getattr(message, name) is False
    setattr(message, name, True)
    assert message.raw.msg_info.value == bit
    assert getattr(message, name) is True
    setattr(message, name, False)
    assert message.raw.msg_info.value == 0


def test_properties_lie_where_the_structure_has_them() -> None:
    message = LinMessage()
    message.time_stamp = 0x01020304
    message.prot_id = 0x50
    message.message_type = v3.LinMessageType.SLEEP
    message.data_length = 8
    message[0], message[7] = 0x11, 0x88
    assert message.raw.to_bytes() == bytes.fromhex("04030201 50050800 1100000000000088")


def test_only_receivers_are_told_of_an_overrun() -> None:
    message = received(LinMsg(msg_info=LinMsgInfo(ovr=1)))
    assert message.possible_overrun is True
    with pytest.raises(AttributeError):
        message.possible_overrun = False  # type: ignore[misc]


@each(
    ("name", "value"),
    [("data_length", 9), ("data_length", -1), ("prot_id", 256), ("time_stamp", 1 << 32), ("message_type", 7)],
)
def test_properties_refuse_what_is_out_of_range(name: str, value: int) -> None:
    message = LinMessage()
    with pytest.raises(ArgumentOutOfRangeException):
        setattr(message, name, value)
    assert message == LinMessage()


@pytest.mark.parametrize("index", [8, -1])
def test_there_are_eight_bytes(index: int) -> None:
    message = LinMessage()
    with pytest.raises(IndexError):
        message[index]
    with pytest.raises(IndexError):
        message[index] = 0
    with pytest.raises(ArgumentException):
        message[0] = 256
    assert [message[at] for at in range(8)] == [0] * 8


def test_messages_are_equal_by_value() -> None:
    one, other = LinMessage(), LinMessage()
    one.prot_id = other.prot_id = 5
    assert one == other
    other.id_only = True
    assert one != other


def test_repr_shows_the_message() -> None:
    message = LinMessage()
    message.prot_id, message.data_length, message[1] = 0x50, 2, 0xAF
    assert repr(message) == "<LinMessage data 0x50 [2] 00 af>"


@pytest.mark.parametrize(
    ("number", "error"), [(4, v3.LinMsgError.SLAVE_NO_RESPONSE), (8, v3.LinMsgError.OTHER)]
)
def test_error_messages_carry_the_numbers_of_v3(number: int, error: v3.LinMsgError) -> None:
    message = received(LinMsg(pid=0xFF, type=vci.LIN_MSGTYPE_ERROR, data=bytes([number, 4])))
    assert (message[0], message[1]) == (error, 4)


def test_data_are_no_error_numbers() -> None:
    assert received(LinMsg(data=b"\x08"))[0] == 8


def test_a_given_message_is_filled() -> None:
    message = LinMessage()
    assert received(LinMsg(pid=0x50), message) is message
    assert message.prot_id == 0x50
