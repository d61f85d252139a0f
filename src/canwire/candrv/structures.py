"""canbusio.h's structures and COMMTIMEOUTS under their own names, as they lie in a 32-bit program's memory.

    data = CAN_TRANSMIT_DATA(identifier=0x123, dlc=2, msg=b"\\x11\\x22")
    CAN_TRANSMIT_DATA.unpack(data.pack()) == data

Little-endian, aligned naturally: two bytes follow CAN_TRANSMIT_DATA.msg. TCHAR is UTF-16LE. A field takes only
what fits it: assigning anything else raises BadValue.
Source: CANDRV manual (seed 000), appendix A and 8.5; rulings.md 16.
"""

# ruff: noqa: N801, N815 - the structures and fields have the manual's names
from __future__ import annotations

import dataclasses
import struct
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar, Self, TypeAlias, get_type_hints

from canwire import BadValue
from canwire.candrv.constants import (
    CANBUS_CMD_LAST_ENTRY,
    CANBUS_NUMBER_OF_CONSTANT_BAUDRATES,
    MAX_DEVICE_NAME_LENGTH,
)


@dataclasses.dataclass(frozen=True, slots=True)
class _Number:
    """A whole number."""

    format: str
    low: int
    high: int

    def checked(self, place: str, value: Any) -> int:
        if not isinstance(value, int) or not self.low <= value <= self.high:
            raise BadValue(f"{place} is {value!r:.40}: a whole number from {self.low} to {self.high}")
        return value

    def bytes_of(self, value: int) -> bytes:
        return struct.pack(f"<{self.format}", value)

    def value_of(self, data: bytes) -> int:
        return int(struct.unpack(f"<{self.format}", data)[0])


@dataclasses.dataclass(frozen=True, slots=True)
class _Numbers:
    """An array; fewer numbers are filled up with zeros."""

    format: str
    count: int
    low: int
    high: int

    def checked(self, place: str, value: Any) -> tuple[int, ...]:
        numbers = tuple(value) if isinstance(value, Iterable) else (value,)
        if len(numbers) > self.count:
            raise BadValue(f"{place} has {len(numbers)} numbers: at most {self.count}")
        one = _Number(self.format[-1], self.low, self.high)
        checked = [one.checked(f"{place}[{at}]", number) for at, number in enumerate(numbers)]
        return tuple(checked) + (0,) * (self.count - len(numbers))

    def bytes_of(self, value: tuple[int, ...]) -> bytes:
        return struct.pack(f"<{self.format}", *value)

    def value_of(self, data: bytes) -> tuple[int, ...]:
        return struct.unpack(f"<{self.format}", data)


@dataclasses.dataclass(frozen=True, slots=True)
class _Octets:
    """CAN_BYTE[size]; fewer bytes are filled up with zeros."""

    size: int

    @property
    def format(self) -> str:
        return f"{self.size}s"

    def checked(self, place: str, value: Any) -> bytes:
        if not isinstance(value, bytes | bytearray | memoryview) or len(bytes(value)) > self.size:
            raise BadValue(f"{place} is {value!r:.40}: at most {self.size} bytes")
        return bytes(value).ljust(self.size, b"\0")

    def bytes_of(self, value: bytes) -> bytes:
        return value

    def value_of(self, data: bytes) -> bytes:
        return data


@dataclasses.dataclass(frozen=True, slots=True)
class _Text:
    """TCHAR[units], ended by a zero."""

    units: int

    @property
    def format(self) -> str:
        return f"{2 * self.units}s"

    def checked(self, place: str, value: Any) -> str:
        try:
            fits = isinstance(value, str) and len(value.encode("utf-16-le")) < 2 * self.units
        except UnicodeEncodeError:
            fits = False
        if not fits or "\0" in value:
            raise BadValue(f"{place} is {value!r:.40}: text of at most {self.units - 1} UTF-16 units")
        return str(value)

    def bytes_of(self, value: str) -> bytes:
        return value.encode("utf-16-le").ljust(2 * self.units, b"\0")

    def value_of(self, data: bytes) -> str:
        return data[: 2 * (self.units - 1)].decode("utf-16-le", "replace").partition("\0")[0]


@dataclasses.dataclass(frozen=True, slots=True)
class _Nested:
    """A structure inside another."""

    structure: type[Structure]

    @property
    def format(self) -> str:
        return f"{self.structure.SIZE}s"

    def checked(self, place: str, value: Any) -> Structure:
        if not isinstance(value, self.structure):
            raise BadValue(f"{place} is {value!r:.40}: a {self.structure.__name__}")
        return value

    def bytes_of(self, value: Structure) -> bytes:
        return value.pack()

    def value_of(self, data: bytes) -> Structure:
        return self.structure.unpack(data)


_Kind: TypeAlias = _Number | _Numbers | _Octets | _Text | _Nested
_UNSIGNED, _SIGNED = (0, 0xFFFF_FFFF), (-0x8000_0000, 0x7FFF_FFFF)

CAN_DWORD: TypeAlias = Annotated[int, _Number("I", *_UNSIGNED)]
CAN_UINT: TypeAlias = Annotated[int, _Number("I", *_UNSIGNED)]
CAN_INT: TypeAlias = Annotated[int, _Number("i", *_SIGNED)]
CAN_BYTE: TypeAlias = Annotated[int, _Number("B", 0, 0xFF)]
DWORD: TypeAlias = CAN_DWORD
EIGHT_BYTES: TypeAlias = Annotated[bytes, _Octets(8)]
DEVICE_NAME: TypeAlias = Annotated[str, _Text(MAX_DEVICE_NAME_LENGTH)]
COMMANDS: TypeAlias = Annotated[
    tuple[int, ...], _Numbers(f"{CANBUS_CMD_LAST_ENTRY}i", CANBUS_CMD_LAST_ENTRY, *_SIGNED)
]
BAUDRATES: TypeAlias = Annotated[
    tuple[int, ...],
    _Numbers(f"{CANBUS_NUMBER_OF_CONSTANT_BAUDRATES}I", CANBUS_NUMBER_OF_CONSTANT_BAUDRATES, *_UNSIGNED),
]


class Structure:
    """What all of them can. `SIZE` in bytes; `OFFSETS` of the fields in memory, in their order."""

    __slots__ = ()
    SIZE: ClassVar[int]
    OFFSETS: ClassVar[dict[str, int]]
    _kinds: ClassVar[dict[str, _Kind]]
    _layout: ClassVar[struct.Struct]

    def __setattr__(self, name: str, value: Any) -> None:
        kind = self._kinds.get(name)
        checked = kind.checked(f"{type(self).__name__}.{name}", value) if kind else value
        object.__setattr__(self, name, checked)

    def pack(self) -> bytes:
        """`SIZE` bytes of memory; what lies between the fields is zero."""
        memory = bytearray(self.SIZE)
        for name, kind in self._kinds.items():
            data = kind.bytes_of(getattr(self, name))
            memory[self.OFFSETS[name] : self.OFFSETS[name] + len(data)] = data
        return bytes(memory)

    @classmethod
    def unpack(cls, data: bytes | bytearray | memoryview) -> Self:
        """The structure in exactly `SIZE` bytes; raises BadValue for any other number."""
        memory = bytes(data)
        if len(memory) != cls.SIZE:
            raise BadValue(f"{cls.__name__} takes {cls.SIZE} bytes, not {len(memory)}")
        fields = {}
        for name, kind in cls._kinds.items():
            at = cls.OFFSETS[name]
            fields[name] = kind.value_of(memory[at : at + struct.calcsize(f"<{kind.format}")])
        return cls(**fields)


def _lay_out(cls: type[Structure]) -> None:
    """Offsets and size from the annotations, each field aligned to its own numbers."""
    hints = get_type_hints(cls, include_extras=True)
    cls._kinds, cls.OFFSETS, size, widest = {}, {}, 0, 1
    for field in dataclasses.fields(cls):  # type: ignore[arg-type]
        hint = hints[field.name]
        kind = hint.__metadata__[0] if hasattr(hint, "__metadata__") else _Nested(hint)
        align = 4 if isinstance(kind, _Nested) else 2 if isinstance(kind, _Text) else _width(kind)
        size += -size % align
        cls._kinds[field.name], cls.OFFSETS[field.name] = kind, size
        size += struct.calcsize(f"<{kind.format}")
        widest = max(widest, align)
    cls.SIZE = size + -size % widest


def _width(kind: _Number | _Numbers | _Octets) -> int:
    return 1 if isinstance(kind, _Octets) else struct.calcsize(f"<{kind.format[-1]}")


@dataclasses.dataclass(slots=True)
class CAN_TIME(Structure):
    """When something happened: `low` counts milliseconds and wraps without touching `high`, which is always 0."""

    low: CAN_DWORD = 0
    high: CAN_DWORD = 0


@dataclasses.dataclass(slots=True)
class CAN_ACCEPTANCE_FILTER(Structure):
    """What a receive channel accepts: see filters.py."""

    code: CAN_DWORD = 0
    mask: CAN_DWORD = 0


@dataclasses.dataclass(slots=True)
class CAN_TRANSMIT_DATA(Structure):
    """A message: `fmt` a FrameFormat, `identifier` aligned as Align says, `dlc` 0..15, up to eight bytes `msg`."""

    fmt: CAN_UINT = 0
    identifier: CAN_DWORD = 0
    rtr: CAN_BYTE = 0
    dlc: CAN_BYTE = 0
    msg: EIGHT_BYTES = bytes(8)


_lay_out(CAN_TIME)
_lay_out(CAN_TRANSMIT_DATA)


@dataclasses.dataclass(slots=True)
class CAN_EVENT(Structure):
    """An event; `data` means something only for messages received, transmitted or aborted."""

    event: CAN_DWORD = 0
    time: CAN_TIME = dataclasses.field(default_factory=CAN_TIME)
    lost: CAN_DWORD = 0
    data: CAN_TRANSMIT_DATA = dataclasses.field(default_factory=CAN_TRANSMIT_DATA)
    arbitration: CAN_UINT = 0


@dataclasses.dataclass(slots=True)
class CAN_PROPERTIES(Structure):
    """What driver and controller can: see properties.py. `version` is major << 8 | minor; rates in bit/s."""

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


@dataclasses.dataclass(slots=True)
class COMMTIMEOUTS(Structure):
    """Milliseconds, 0 at once, INFINITE for ever; ReadIntervalTimeout and ReadTotalTimeoutMultiplier mean nothing."""

    ReadIntervalTimeout: DWORD = 0
    ReadTotalTimeoutMultiplier: DWORD = 0
    ReadTotalTimeoutConstant: DWORD = 0
    WriteTotalTimeoutMultiplier: DWORD = 0
    WriteTotalTimeoutConstant: DWORD = 0


for _structure in (CAN_ACCEPTANCE_FILTER, CAN_EVENT, CAN_PROPERTIES, COMMTIMEOUTS):
    _lay_out(_structure)

# a pointer to a structure is the structure
PCAN_TIME = CAN_TIME
PCAN_ACCEPTANCE_FILTER = CAN_ACCEPTANCE_FILTER
PCAN_TRANSMIT_DATA = CAN_TRANSMIT_DATA
PCAN_EVENT = CAN_EVENT
PCAN_PROPERTIES = CAN_PROPERTIES
LPCOMMTIMEOUTS = COMMTIMEOUTS
