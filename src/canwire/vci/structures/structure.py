"""Packed C structures, each declared once.

A structure is a class whose members declare their C name and memory layout; the constructor, packing, comparison and
text follow from that declaration.

    @structure("CANINITLINE")
    class CanInitLine(Structure):
        op_mode: int = u8("bOpMode")
        reserved: int = u8("bReserved")
        bt_reg0: int = u8("bBtReg0")
        bt_reg1: int = u8("bBtReg1")

Source: VCI V4 headers (pshpack1.h: no padding; little-endian); reference/vci.md section 5.
"""

from __future__ import annotations

import copy
import dataclasses
import struct
from collections.abc import Callable
from typing import Any, ClassVar, Self, TypeVar, dataclass_transform

from canwire.packed.layout import Layout, Misfit, brief
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciError
from canwire.vci.structures.members import Member


class Structure:
    """The base of all structures. Members may be changed at any time; they are checked when packed.

    `NAME` is the C name, `SIZE` is in bytes, `FIELDS` contains pairs of C name and Python name, including further names
    in the manual. A constructor accepts the members by name, or in their order like a C initialiser; the default of
    each is 0.
    """

    __slots__ = ()
    NAME: ClassVar[str]
    SIZE: ClassVar[int]
    FIELDS: ClassVar[tuple[tuple[str, str], ...]]
    _members: ClassVar[tuple[Member, ...]]
    _layout: ClassVar[Layout]

    def __post_init__(self) -> None:
        for member in self._members:
            if member.complete is not None:
                setattr(self, member.name, member.complete(getattr(self, member.name)))

    def to_bytes(self) -> bytes:
        """The structure as it is in C's memory, `SIZE` bytes.

        Raises VciInvalidArgument, which names the first member that does not fit.
        """
        try:
            return self._layout.pack(self)
        except Misfit as misfit:
            raise self._refused(misfit) from None

    @classmethod
    def from_bytes(cls, data: bytes | bytearray | memoryview) -> Self:
        """The structure in exactly `SIZE` bytes; raises VciInvalidArgument for any other number."""
        made = cls.__new__(cls)
        values = cls._layout.decoded(cls._unpack(data))
        for name, value in zip(cls._layout.kinds, values, strict=True):
            setattr(made, name, value)
        return made

    @classmethod
    def _unpack(cls, data: bytes | bytearray | memoryview) -> tuple[Any, ...]:
        """The items in memory, before they are decoded."""
        try:
            return cls._layout.struct.unpack(data)
        except (struct.error, TypeError):
            raise VciError(VCI_E_INVALIDARG, f"{cls.NAME} takes {cls.SIZE} bytes") from None

    def copy(self) -> Self:
        """A deep copy: nested structures and arrays are copied, too."""
        return copy.deepcopy(self)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Structure) or other.NAME != self.NAME:
            return NotImplemented
        return all(getattr(self, one.name) == getattr(other, one.name) for one in self._members)

    def __repr__(self) -> str:
        """A Python expression; members that are 0 are omitted."""
        shown = [
            f"{member.name}={member.show(value)}"
            for member in self._members
            if (value := getattr(self, member.name)) != member.default()
        ]
        return f"{type(self).__name__}({', '.join(shown)})"

    def _refused(self, misfit: Misfit) -> VciError:
        c_name = next(one.c_name for one in self._members if one.name == misfit.name)
        place = f"{self.NAME}.{c_name} ({misfit.name})"
        return VciError(VCI_E_INVALIDARG, f"{place} is {brief(misfit.value, 60)}: not {misfit.wants}")


S = TypeVar("S", bound=Structure)


@dataclass_transform(eq_default=False)
def structure(
    c_name: str, *, init: bool = True, also: tuple[tuple[str, str], ...] = ()
) -> Callable[[type[S]], type[S]]:
    """Make a structure from a class with members; `also` contains further C names with their Python names."""

    def declare(cls: type[S]) -> type[S]:
        made: Any = dataclasses.dataclass(init=init, eq=False, repr=False, slots=True)(cls)
        members = [
            dataclasses.replace(field.metadata["member"], name=field.name)
            for field in dataclasses.fields(made)
        ]
        made.NAME = c_name
        made.FIELDS = (*((one.c_name, one.name) for one in members), *also)
        made._members = tuple(members)
        made._layout = Layout({one.name: one.kind for one in members})
        made.SIZE = made._layout.size
        return made

    return declare
