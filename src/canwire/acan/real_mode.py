"""The machine of a program in the real mode of an 8086: a megabyte of memory, far pointers, registers."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

from canwire import BadValue

MEGABYTE = 1 << 20
_POINTER = struct.Struct("<HH")


class FarPointer(NamedTuple):
    """segment:offset; both 0 is NULL. Different far pointers can point to the same byte."""

    segment: int
    offset: int

    @classmethod
    def of(cls, double_word: int) -> Self:
        """The far pointer in a double word: the offset is the low word."""
        return cls(double_word >> 16, double_word & 0xFFFF)

    @property
    def linear(self) -> int:
        """The address of the byte it points to; after the megabyte addresses begin at 0 again."""
        return (self.segment * 16 + self.offset) % MEGABYTE

    def __bool__(self) -> bool:
        return self.segment != 0 or self.offset != 0

    def __add__(self, distance: int) -> FarPointer:  # type: ignore[override]
        return FarPointer(self.segment, (self.offset + distance) & 0xFFFF)

    def __str__(self) -> str:
        return f"{self.segment:04X}:{self.offset:04X}"


class ByteMemory:
    """A megabyte of memory, zeros at first. An access beyond its end raises BadValue."""

    def __init__(self) -> None:
        self._bytes = bytearray(MEGABYTE)

    def view(self, at: FarPointer, size: int) -> memoryview:
        """A writable view of `size` bytes from `at`."""
        first = at.linear
        if first + size > MEGABYTE:
            raise BadValue(f"{size} bytes at {at} reach over the end of the memory")
        return memoryview(self._bytes)[first : first + size]

    def read(self, at: FarPointer, size: int) -> bytes:
        return bytes(self.view(at, size))

    def write(self, at: FarPointer, data: bytes) -> None:
        self.view(at, len(data))[:] = data

    def read_pointer(self, at: FarPointer) -> FarPointer:
        """The far pointer in memory at `at`."""
        offset, segment = _POINTER.unpack(self.view(at, _POINTER.size))
        return FarPointer(segment, offset)

    def write_pointer(self, at: FarPointer, to: FarPointer) -> None:
        self.write(at, _POINTER.pack(to.offset, to.segment))


class _Half:
    """One byte of a word register."""

    def __init__(self, word: str, shift: int) -> None:
        self.word = word
        self.shift = shift

    def __get__(self, registers: Registers, _owner: object = None) -> int:
        return int(getattr(registers, self.word)) >> self.shift & 0xFF

    def __set__(self, registers: Registers, value: int) -> None:
        kept = getattr(registers, self.word) & ~(0xFF << self.shift)
        setattr(registers, self.word, kept | value << self.shift)


@dataclass(slots=True)
class Registers:
    """The word registers, and the bytes of AX to DX. A value that does not fit raises BadValue."""

    AX: int = 0
    BX: int = 0
    CX: int = 0
    DX: int = 0
    SI: int = 0
    DI: int = 0
    BP: int = 0
    SP: int = 0
    DS: int = 0
    ES: int = 0
    SS: int = 0

    AH, AL = _Half("AX", 8), _Half("AX", 0)
    BH, BL = _Half("BX", 8), _Half("BX", 0)
    CH, CL = _Half("CX", 8), _Half("CX", 0)
    DH, DL = _Half("DX", 8), _Half("DX", 0)

    def __setattr__(self, name: str, value: Any) -> None:
        largest = 0xFF if name[1] in "HL" else 0xFFFF
        if not isinstance(value, int) or not 0 <= value <= largest:
            raise BadValue(f"{name} is {value!r:.40}: a whole number from 0 to 0x{largest:X}")
        object.__setattr__(self, name, value)

    def pointer(self, segment: str, offset: str) -> FarPointer:
        """The far pointer in the two registers with these names, for example "ES" and "BX"."""
        return FarPointer(getattr(self, segment), getattr(self, offset))

    def point(self, segment: str, offset: str, to: FarPointer) -> None:
        """Write a far pointer into the two registers with these names."""
        setattr(self, segment, to.segment)
        setattr(self, offset, to.offset)
