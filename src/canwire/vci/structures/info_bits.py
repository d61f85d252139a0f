"""Bit fields of the message information words, CANMSGINFO and LINMSGINFO."""

from __future__ import annotations

import operator
from typing import Protocol, Self, overload

from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciError


class InfoWord(Protocol):
    """What the fields are fields of."""

    value: int


class BitField:
    """Some bits of an information word. Setting them to more than they hold raises VciInvalidArgument."""

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
            raise VciError(VCI_E_INVALIDARG, f"{self.structure}'s {self.name} is from 0 to {self.highest}")
        info.value = info.value & ~(self.highest << self.shift) | number << self.shift
