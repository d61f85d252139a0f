"""The structures of canbusio.h and COMMTIMEOUTS, with their names and with the memory layout of a 32-bit program.

    data = CAN_TRANSMIT_DATA(identifier=0x123, dlc=2, msg=b"\\x11\\x22")
    CAN_TRANSMIT_DATA.unpack(data.pack()) == data

They are little-endian and naturally aligned: two bytes of padding follow CAN_TRANSMIT_DATA.msg. TCHAR is UTF-16LE.
Assigning a value that does not fit a field raises BadValue.
Source: CANDRV manual, appendix A and 8.5; rulings.md 16.
"""

# ruff: noqa: N801, N815 - the structures and fields have the manual's names
from __future__ import annotations

import dataclasses
from typing import Annotated, Any, TypeAlias

from canwire.candrv.constants import (
    CANBUS_CMD_LAST_ENTRY,
    CANBUS_NUMBER_OF_CONSTANT_BAUDRATES,
    MAX_DEVICE_NAME_LENGTH,
)
from canwire.packed.kinds import number, numbers
from canwire.packed.layout import Kind, Misfit
from canwire.packed.record import Record, record

_MOST_DATA = 8


def _text(units: int) -> Kind:
    """TCHAR[units] in UTF-16, ended by a zero; the last unit is ignored, also in a text without a zero."""
    wants = f"text of at most {units - 1} UTF-16 units"

    def fit(value: Any) -> str:
        try:
            fits = isinstance(value, str) and len(value.encode("utf-16-le")) < 2 * units
        except UnicodeEncodeError:
            fits = False
        if not fits or "\0" in value:
            raise Misfit(value, wants)
        return str(value)

    def decode(data: bytes) -> str:
        return data[: 2 * (units - 1)].decode("utf-16-le", "replace").partition("\0")[0]

    return Kind(f"{2 * units}s", wants, fit, lambda value: value.encode("utf-16-le"), decode, align=2)


def _message() -> Kind:
    """CAN_BYTE[8] whose bytes can be assigned one by one, as in 8.19; a shorter value is padded with zeros."""
    wants = f"at most {_MOST_DATA} bytes"

    def fit(value: Any) -> bytearray:
        if not isinstance(value, bytes | bytearray | memoryview) or memoryview(value).nbytes > _MOST_DATA:
            raise Misfit(value, wants)
        return bytearray(bytes(value).ljust(_MOST_DATA, b"\0"))

    return Kind(f"{_MOST_DATA}s", wants, fit, bytes, bytearray)


CAN_DWORD: TypeAlias = Annotated[int, number("I")]
CAN_UINT: TypeAlias = Annotated[int, number("I")]
CAN_INT: TypeAlias = Annotated[int, number("i")]
CAN_BYTE: TypeAlias = Annotated[int, number("B")]
DWORD: TypeAlias = CAN_DWORD
EIGHT_BYTES: TypeAlias = Annotated[bytes | bytearray, _message()]
DEVICE_NAME: TypeAlias = Annotated[str, _text(MAX_DEVICE_NAME_LENGTH)]
COMMANDS: TypeAlias = Annotated[tuple[int, ...], numbers("i", CANBUS_CMD_LAST_ENTRY)]
BAUDRATES: TypeAlias = Annotated[tuple[int, ...], numbers("I", CANBUS_NUMBER_OF_CONSTANT_BAUDRATES)]


class Structure(Record):
    """The base of all structures. `SIZE` is in bytes; `OFFSETS` has the offset of each field in memory, in order."""

    __slots__ = ()


@record(natural=True)
class CAN_TIME(Structure):
    """The time of an event: `low` counts milliseconds and wraps at 32 bits; `high` is always 0."""

    low: CAN_DWORD = 0
    high: CAN_DWORD = 0


@record(natural=True)
class CAN_ACCEPTANCE_FILTER(Structure):
    """The acceptance filter of a receive channel: see filters.py."""

    code: CAN_DWORD = 0
    mask: CAN_DWORD = 0


@record(natural=True)
class CAN_TRANSMIT_DATA(Structure):
    """A message: `fmt` is a FrameFormat, `identifier` is aligned by Align, `dlc` 0..15, `msg` up to eight bytes."""

    fmt: CAN_UINT = 0
    identifier: CAN_DWORD = 0
    rtr: CAN_BYTE = 0
    dlc: CAN_BYTE = 0
    msg: EIGHT_BYTES = bytes(8)


@record(natural=True)
class CAN_EVENT(Structure):
    """An event; `data` is valid only for messages received, transmitted or aborted."""

    event: CAN_DWORD = 0
    time: CAN_TIME = dataclasses.field(default_factory=CAN_TIME)
    lost: CAN_DWORD = 0
    data: CAN_TRANSMIT_DATA = dataclasses.field(default_factory=CAN_TRANSMIT_DATA)
    arbitration: CAN_UINT = 0


@record(natural=True)
class CAN_PROPERTIES(Structure):
    """Properties of driver and controller: see properties.py. `version` is major << 8 | minor; rates are in bit/s."""

    version: CAN_DWORD = 0
    device_name: DEVICE_NAME = ""
    min: CAN_DWORD = 0
    max: CAN_DWORD = 0
    nCommands: CAN_INT = 0
    commands: COMMANDS = (0,) * CANBUS_CMD_LAST_ENTRY
    nBaudrates: CAN_INT = 0
    baudrates: BAUDRATES = (0,) * CANBUS_NUMBER_OF_CONSTANT_BAUDRATES
    chipset_flags: CAN_DWORD = 0
    nRegisters: CAN_INT = 0


@record(natural=True)
class COMMTIMEOUTS(Structure):
    """Timeouts in milliseconds: 0 does not wait, INFINITE waits without limit.

    ReadIntervalTimeout and ReadTotalTimeoutMultiplier are ignored.
    """

    ReadIntervalTimeout: DWORD = 0
    ReadTotalTimeoutMultiplier: DWORD = 0
    ReadTotalTimeoutConstant: DWORD = 0
    WriteTotalTimeoutMultiplier: DWORD = 0
    WriteTotalTimeoutConstant: DWORD = 0


# a pointer to a structure is the structure
PCAN_TIME = CAN_TIME
PCAN_ACCEPTANCE_FILTER = CAN_ACCEPTANCE_FILTER
PCAN_TRANSMIT_DATA = CAN_TRANSMIT_DATA
PCAN_EVENT = CAN_EVENT
PCAN_PROPERTIES = CAN_PROPERTIES
LPCOMMTIMEOUTS = COMMTIMEOUTS
