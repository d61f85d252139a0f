"""Enumerations: V3's values as reference/vci.md sections 2 and 3 give them, in the spelling of sections 7a and 9."""

from __future__ import annotations

from enum import Enum

import pytest

from canwire.vci import v3
from canwire.vci.v3.can.enums import V3_ERRORS
from tests.cases import each

VALUES: dict[type[Enum], dict[str, int]] = {
    v3.VciBusType: {"UNKNOWN": 0, "CAN": 1, "LIN": 2, "FLEX_RAY": 3, "K_LINE": 4},
    v3.CanCtrlType: {
        "UNKNOWN": 0,
        "INTEL_82527": 1,
        "INTEL_82C200": 2,
        "INTEL_81C90": 3,
        "INTEL_81C92": 4,
        "SJA1000": 5,
        "INFINEON_82C900": 6,
        "TOUCAN": 7,
        "MSCAN": 8,
        "FLEXCAN": 9,
        "IFI_CAN": 0x0A,
        "C_CAN": 0x0B,
        "BXCAN": 0x0C,
        "IFI_CAN_FD": 0x0D,
        "M_CAN": 0x0E,
    },
    v3.CanBusCouplings: {"UNDEFINED": 0, "LOW_SPEED": 1, "HIGH_SPEED": 2},
    v3.CanFeatures: {
        "STD_OR_EXT": 0x1,
        "STD_AND_EXT": 0x2,
        "REMOTE_FRAME": 0x4,
        "ERR_FRAME": 0x8,
        "BUSLOAD": 0x10,
        "ID_FILTER": 0x20,
        "LIST_ONLY": 0x40,
        "SCHEDULER": 0x80,
        "GEN_ERR_FRAME": 0x100,
        "DELAYED_TX": 0x200,
        "SINGLE_SHOT": 0x400,
        "HIGH_PRIORITY_MSG": 0x800,
        "CAN_FD": 0x1000,
    },
    v3.CanOperatingModes: {
        "UNDEFINED": 0,
        "STANDARD": 0x01,
        "EXTENDED": 0x02,
        "MODE_MASK": 0x03,
        "ERR_FRAME": 0x04,
        "LISTEN_ONLY": 0x08,
        "LOW_SPEED": 0x10,
    },
    v3.CanCtrlStatus: {
        "TX_PENDING": 0x01,
        "OVERRUN": 0x02,
        "ERR_LIMIT": 0x04,
        "BUS_OFF": 0x08,
        "IN_INIT": 0x10,
        "BUS_C_ERR": 0x20,
    },
    v3.CanFilter: {"STD": 1, "EXT": 2},
    v3.CanAccMask: {"ALL": 0, "NONE": 0xFFFFFFFF},
    v3.CanAccCode: {"ALL": 0, "NONE": 0x80000000},
    v3.CanMsgFrameType: {
        "DATA": 0,
        "INFO": 1,
        "ERROR": 2,
        "STATUS": 3,
        "WAKEUP": 4,
        "TIME_OVERRUN": 5,
        "TIME_RESET": 6,
    },
    v3.CanMsgInfoValue: {"START": 1, "STOP": 2, "RESET": 3},
    v3.CanMsgError: {"STUFF": 1, "FORM": 2, "ACKNOWLEDGE": 3, "BIT": 4, "CRC": 6, "OTHER": 7},
    v3.CanMsgAccReason: {"REJECT": 0, "FILTER_1": 1, "FILTER_2": 2, "ALWAYS": 0xFF},
    v3.CanCyclicTXIncMode: {"NO_INC": 0, "INC_ID": 1, "INC_8": 2, "INC_16": 3, "INC_1": 1},
    v3.CanCyclicTXStatus: {"EMPTY": 0, "BUSY": 1, "DONE": 2},
    v3.CanCyclicTXTaskStatus: {"STOPPED": 0, "RUNNING": 1},
}


@pytest.mark.finding("vendor 11")
@each("kind", VALUES, ids=lambda kind: kind.__name__)
def test_members(kind: type[Enum]) -> None:
    assert {name: member.value for name, member in kind.__members__.items()} == VALUES[kind]


@each(
    ("v4", "expected"),
    [
        (0, v3.CanMsgError.OTHER),
        (1, v3.CanMsgError.STUFF),
        (2, v3.CanMsgError.FORM),
        (3, v3.CanMsgError.ACKNOWLEDGE),
        (4, v3.CanMsgError.BIT),
        (5, v3.CanMsgError.BIT),
        (6, v3.CanMsgError.CRC),
        (7, v3.CanMsgError.OTHER),
        (8, v3.CanMsgError.OTHER),
    ],
)
def test_errors_get_the_numbers_of_v3(v4: int, expected: v3.CanMsgError) -> None:
    assert V3_ERRORS[v4] is expected


def test_controllers_and_buses_that_v3_does_not_know_are_unknown() -> None:
    assert v3.CanCtrlType(0x41) is v3.CanCtrlType.UNKNOWN
    assert v3.VciBusType(9) is v3.VciBusType.UNKNOWN


def test_what_an_excluding_filter_let_through_was_always_accepted() -> None:
    assert v3.CanMsgAccReason(3) is v3.CanMsgAccReason.ALWAYS
