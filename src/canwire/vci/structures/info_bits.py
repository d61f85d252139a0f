"""Message information words, CANMSGINFO and LINMSGINFO: 32 bits with named fields, and their member in a message."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from typing import Any, ClassVar, Self, overload

from canwire.packed.layout import Kind
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciError
from canwire.vci.structures.members import member
from canwire.vci.structures.structure import Structure


class InfoWord(Structure):
    """A 32-bit `value` with bit fields: those in `BITS` are keyword arguments, those in `IN_HEX` are printed in hex."""

    __slots__ = ("value",)
    BITS: ClassVar[tuple[str, ...]]
    IN_HEX: ClassVar[tuple[str, ...]] = ()
    value: int

    def _put(self, value: int, bits: Mapping[str, object]) -> None:
        self.value = value
        for name, given in bits.items():
            if name not in self.BITS:
                raise TypeError(f"{self.NAME} has no bit field {name!r}")
            setattr(self, name, given)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(shown_bits(self))})"


class BitField:
    """A bit field of an information word. Assigning a number that does not fit raises VciInvalidArgument."""

    __slots__ = ("highest", "name", "shift", "structure")

    def __init__(self, shift: int, width: int) -> None:
        self.shift = shift
        self.highest = (1 << width) - 1

    def __set_name__(self, owner: type, name: str) -> None:
        self.structure = owner.__name__.upper()  # CanMsgInfo is CANMSGINFO
        self.name = name

    @overload
    def __get__(self, info: None, owner: type) -> Self: ...
    @overload
    def __get__(self, info: InfoWord, owner: type) -> int: ...
    def __get__(self, info: InfoWord | None, owner: type) -> Self | int:
        return self if info is None else info.value >> self.shift & self.highest

    def __set__(self, info: InfoWord, bits: int) -> None:
        try:
            number = operator.index(bits)
        except TypeError:
            number = -1
        if not 0 <= number <= self.highest:
            raise VciError(VCI_E_INVALIDARG, f"{self.structure}'s {self.name} must be 0 to {self.highest}")
        info.value = info.value & ~(self.highest << self.shift) | number << self.shift


def shown_bits(info: InfoWord) -> list[str]:
    """The bit fields that are not 0, as keyword arguments."""
    given = [(name, getattr(info, name)) for name in info.BITS]
    return [
        f"{name}={value:#x}" if name in info.IN_HEX else f"{name}={value}" for name, value in given if value
    ]


def info_member(of: type[InfoWord]) -> Any:
    """The member uMsgInfo of a message."""
    kind = Kind("I", f"a {of.__name__} of 32 bits", encode=operator.attrgetter("value"), decode=of)
    return member("uMsgInfo", kind, of)
