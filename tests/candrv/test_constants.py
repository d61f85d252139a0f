"""Constants have canbusio.h's and Win32's values. Source: CANDRV manual, appendix A; rulings.md 16, 20."""

from __future__ import annotations

import re
from enum import Enum
from pathlib import Path

import pytest

from canwire import candrv
from canwire.candrv import constants

MANUAL = Path(__file__).resolve().parents[3] / "shared" / "seeds" / "000_c4a7ca42d189c1e6.txt"

EVENTS = {
    "RECEIVED": 0x001,
    "TRANSMITTED": 0x002,
    "BUS_ERROR": 0x004,
    "WARNING": 0x008,
    "LEAVING_STANDBY": 0x010,
    "ARBITRATION_LOST": 0x020,
    "OVERRUN": 0x040,
    "PASSIVE": 0x080,
    "ENTERING_STANDBY": 0x100,
    "DEVICE_CHANGED": 0x200,
    "ABORTED": 0x400,
}
COMMANDS = [
    "ENTER_STANDBY",
    "ABORT_TRANSMISSION",
    "CLEAR_OVERRUN",
    "LEAVE_STANDBY",
    "SELF_RECEPTION_REQUEST",
    "LISTEN_ON",
    "LISTEN_OFF",
    "VIRTUALIZE_ON",
    "VIRTUALIZE_OFF",
    "LAST_ENTRY",
]
ANY, READ, WRITE = 0x8007_0000, 0x8007_4000, 0x8007_8000
CODES = {  # CTL_CODE(0x8007, 0x801.., METHOD_BUFFERED, access), worked out by hand: function << 2
    "WRITE_ACCEPTANCE_FILTER": WRITE | 0x2004,
    "READ_ACCEPTANCE_FILTER": READ | 0x2008,
    "SET_BAUDRATE": ANY | 0x200C,
    "GET_BAUDRATE": ANY | 0x2010,
    "INIT": ANY | 0x2014,
    "SET_BAUDRATE_BY_CONSTANT": ANY | 0x2018,
    "GET_BAUDRATE_BY_CONSTANT": ANY | 0x201C,
    "SET_CAN_MODE": ANY | 0x2020,
    "SET_COMMAND": ANY | 0x2024,
    "WRITE_TRANSMIT_DATA": WRITE | 0x2028,
    "READ_EVENT_DATA": ANY | 0x202C,
    "READ_TIME": READ | 0x2030,
    "SET_DEFAULT_FRAME_FORMAT": ANY | 0x2034,
    "TEST_DEVICE": ANY | 0x2038,
    "READ_PROPERTIES": ANY | 0x203C,
    "READ_REGISTER": ANY | 0x2040,
    "WRITE_REGISTER": ANY | 0x2044,
    "READ_REGISTER_RM": ANY | 0x2048,
    "WRITE_REGISTER_RM": ANY | 0x204C,
}
OTHERS = {
    "MAX_DEVICE_NAME_LENGTH": 100,
    "CANBUS_NUMBER_OF_CONSTANT_BAUDRATES": 50,
    "CANBUS_FORMAT_CAN_2_0_A": 0,
    "CANBUS_FORMAT_CAN_2_0_B": 1,
    "CANBUS_CFS_CAN_2_0_A": 1,
    "CANBUS_CFS_CAN_2_0_B": 2,
    "CANBUS_CFS_EXT_FRAME": 4,
    "CANBUS_CFS_POLLING": 8,
    "CANBUS_TRANS_FMT_DEFAULT": 0,
    "CANBUS_TRANS_FMT_STD": 1,
    "CANBUS_TRANS_FMT_EXT": 2,
    "CAN_DEV": 0x8007,
    "CAN_BUFF": 0,
    "CAN_ANY": 0,
    "CAN_READ": 1,
    "CAN_WRITE": 2,
    "GENERIC_READ": 0x8000_0000,
    "GENERIC_WRITE": 0x4000_0000,
    "FILE_SHARE_READ": 1,
    "FILE_SHARE_WRITE": 2,
    "CREATE_ALWAYS": 2,
    "OPEN_EXISTING": 3,
    "FILE_FLAG_WRITE_THROUGH": 0x8000_0000,
    "INVALID_HANDLE_VALUE": -1,
    "INFINITE": 0xFFFF_FFFF,
    "ERROR_ACCESS_DENIED": 5,
    "ERROR_INVALID_HANDLE": 6,
    "ERROR_NOT_SUPPORTED": 50,
    "ERROR_INVALID_PARAMETER": 87,
    "ERROR_INSUFFICIENT_BUFFER": 122,
    "ERROR_OPERATION_ABORTED": 995,
    "ERROR_NO_SYSTEM_RESOURCES": 1450,
    "ERROR_TIMEOUT": 1460,
}
TABLE = {
    **{f"CANBUS_EVENT_{name}": value for name, value in EVENTS.items()},
    **{f"CANBUS_CMD_{name}": value for value, name in enumerate(COMMANDS, 1)},
    **{f"IOCTL_CAN_{name}": value for name, value in CODES.items()},
    **OTHERS,
}


@pytest.mark.conforms("FS-13", "FS-48")
@pytest.mark.parametrize(("name", "value"), TABLE.items())
def test_values(name: str, value: int) -> None:
    assert getattr(candrv, name) == value
    assert name in candrv.__all__


@pytest.mark.conforms("FS-13")
def test_there_are_nineteen_control_codes() -> None:
    assert len(CODES) == len(constants.ControlCode) == len(set(constants.ControlCode)) == 19


@pytest.mark.parametrize("name", CODES)
def test_a_control_code_tells_the_access_it_takes(name: str) -> None:
    wanted = {ANY: 0, READ: 1, WRITE: 2}[CODES[name] & 0xFFFF_C000]
    assert constants.ControlCode[name].access == wanted


@pytest.mark.parametrize(
    ("enumeration", "prefix"),
    [
        (constants.CanbusEvent, "CANBUS_EVENT_"),
        (constants.Command, "CANBUS_CMD_"),
        (constants.CanMode, "CANBUS_FORMAT_"),
        (constants.FrameFormat, "CANBUS_TRANS_FMT_"),
        (constants.ChipsetFlags, "CANBUS_CFS_"),
        (constants.ControlCode, "IOCTL_CAN_"),
        (constants.Win32Error, ""),
    ],
)
def test_every_member_has_the_manuals_name_too(enumeration: type[Enum], prefix: str) -> None:
    for name, member in enumeration.__members__.items():
        assert getattr(candrv, prefix + name) is member


def test_every_event_is_in_the_mask_of_a_new_channel() -> None:
    assert sum(EVENTS.values()) == constants.EVERY_EVENT == 0x7FF


@pytest.mark.skipif(not MANUAL.is_file(), reason="the manual is not here")
@pytest.mark.conforms("FS-13")
def test_the_header_in_the_manual_says_the_same() -> None:
    text = re.sub(r"<\|.*?\|>", "", MANUAL.read_text(encoding="utf-8"))
    header = text[text.index("#ifndef __CANBUSIO_H__") : text.index("#endif /*!__CANBUSIO_H__*/")]
    header = re.sub(r"\s+", " ", header)
    plain = re.findall(r"#define (C\w+|MAX\w+) (0x[0-9A-F]+|\d+|\(1<<\d\))", header)
    assert len(plain) == 12
    for name, value in plain:
        number = 1 << int(value[4]) if value.startswith("(") else int(value, 0)
        assert getattr(candrv, name) == number, name
    events = re.findall(r"(CANBUS_EVENT_\w+) = (0x\w+)", header)
    assert {name: int(value, 16) for name, value in events} == {
        f"CANBUS_EVENT_{n}": v for n, v in EVENTS.items()
    }
    commands = re.findall(r"(CANBUS_CMD_\w+)(?: = 1)?,|(CANBUS_CMD_LAST_ENTRY)", header)
    assert ["".join(one)[len("CANBUS_CMD_") :] for one in commands][: len(COMMANDS)] == COMMANDS
    codes = re.findall(r"(IOCTL_CAN_\w+) \\ CTL_CODE\(CAN_DEV, (0x\w+), CAN_BUFF, CAN_(\w+)\)", header)
    assert len(codes) == 19
    for name, function, access in codes:
        wanted = 0x8007 << 16 | {"ANY": 0, "READ": 1, "WRITE": 2}[access] << 14 | int(function, 16) << 2
        assert getattr(candrv, name) == wanted, name
