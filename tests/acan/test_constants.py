"""ACAN.H's constants have the manual's numbers. Source: INduCAN104 manual, "Data structures", annex A."""

from __future__ import annotations

import pytest

from canwire import acan
from tests.cases import each

VALUES = {
    "FF_EXTENDED": 0x80,
    "FF_RTR": 0x40,
    "IDA_NOTIFY": 0x80,
    "IDA_QUEUEMSG": 0x40,
    "IDA_CHANRCV": 0x20,
    "IDA_CHANSND": 0x10,
    "TBNT_EVENT": 0,
    "TBNT_CALLBACK": 1,
    "TBNT_POSTMESSAGE": 2,
    "TBS_SC": 0x01,
    "TBS_MB": 0x02,
    "TBS_OVERFLOW": 0x04,
    "SC_BUSERR": 0x80,
    "SC_ARBLOST": 0x40,
    "SC_ERRPAS": 0x20,
    "SC_WAKEUP": 0x10,
    "SC_OVERRUN": 0x08,
    "SC_NOBUFF": 0x04,
    "SC_ERRLIM": 0x02,
    "SC_BUSOFF": 0x01,
    "BUS_OFF": 0,
    "BUS_ON": 1,
    "CANC_SJA1000": 0,
    "ACAN_GET_VERSION": 0,
    "ACAN_HARD_CONFIGURE": 1,
    "ACAN_HARD_STATUS": 2,
    "ACAN_HARD_CONTROL": 3,
    "ACAN_REGISTER": 4,
    "ACAN_ACK": 5,
    "ACAN_FREE": 6,
    "ACAN_SEND": 7,
    "ACAN_RECEIVE": 8,
    "ACAN_GET_VERSION_1": 9,
}


@pytest.mark.conforms("AC-27", "AC-37")
@each(("name", "value"), VALUES.items())
def test_values(name: str, value: int) -> None:
    assert getattr(acan, name) == value
    assert name in acan.__all__


@pytest.mark.conforms("AC-37")
@each(
    ("cls", "prefix"),
    [
        (acan.Format, "FF_"),
        (acan.Action, "IDA_"),
        (acan.Notification, "TBNT_"),
        (acan.BlockStatus, "TBS_"),
        (acan.Condition, "SC_"),
        (acan.BusState, "BUS_"),
        (acan.Service, "ACAN_"),
    ],
)
def test_every_member_has_the_manuals_name_too(cls: type, prefix: str) -> None:
    named = {value for name, value in vars(acan).items() if name.startswith(prefix) and name in VALUES}
    assert named == set(cls)


@pytest.mark.conforms("AC-13")
def test_the_default_interrupts_are_the_manuals() -> None:
    """Bus Error, Error Passive, Data Overrun, Error Warning and Receive: 10101101b."""
    assert acan.DEFAULT_INTERRUPTS == 0b10101101
    assert acan.DEFAULT_OUTPUT_CONTROL == 0b01101010


def test_a_status_word_takes_apart_and_prints() -> None:
    word = acan.TBS_SC | acan.SC_BUSERR << 8
    assert acan.BlockStatus(word & 0xFF) is acan.TBS_SC
    assert acan.Condition(word >> 8) is acan.SC_BUSERR
    assert "BUSERR|BUSOFF" in repr(acan.SC_BUSERR | acan.SC_BUSOFF)
