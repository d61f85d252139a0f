"""Packed C structures, each declared once: a class whose annotations are C's types.

Source: INduCAN104 manual (seed 001), "Programming interface" (definitions).
"""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Self, TypeAlias, get_type_hints

from canwire import BadValue


@dataclasses.dataclass(frozen=True, slots=True)
class Unsigned:
    """A whole number of `size` bytes."""

    format: str
    size: int

    def checked(self, place: str, value: Any) -> Any:
        limit = (1 << 8 * self.size) - 1
        if not isinstance(value, int) or not 0 <= value <= limit:
            raise BadValue(f"{place} is {value!r:.40}: a whole number from 0 to 0x{limit:X}")
        return value

    def packed(self, _place: str, value: Any) -> Any:
        return value

    def unpacked(self, value: Any) -> Any:
        return value


@dataclasses.dataclass(frozen=True, slots=True)
class Octets:
    """BYTE[size]; fewer bytes are filled up with zeros."""

    size: int

    @property
    def format(self) -> str:
        return f"{self.size}s"

    def checked(self, place: str, value: Any) -> Any:
        if not isinstance(value, bytes | bytearray | memoryview) or len(bytes(value)) > self.size:
            raise BadValue(f"{place} is {value!r:.40}: at most {self.size} bytes")
        return bytes(value).ljust(self.size, b"\0")

    def packed(self, _place: str, value: Any) -> Any:
        return value

    def unpacked(self, value: Any) -> Any:
        return value


@dataclasses.dataclass(frozen=True, slots=True)
class Pointer:
    """A far pointer, segment << 16 | offset; NULL is `null` in Python."""

    null: Any = None
    format: str = "I"

    def checked(self, place: str, value: Any) -> Any:
        return DOUBLE_WORD.checked(place, value) if isinstance(value, int) else value

    def packed(self, place: str, value: Any) -> Any:
        if value is not None and not isinstance(value, int):
            raise BadValue(f"{place} is {value!r:.40}: only a far pointer has a place in memory")
        return value or 0

    def unpacked(self, value: Any) -> Any:
        return value or self.null


Kind: TypeAlias = Unsigned | Octets | Pointer
DOUBLE_WORD = Unsigned("I", 4)

BOOL: TypeAlias = bool
BYTE: TypeAlias = Annotated[int, Unsigned("B", 1)]
WORD: TypeAlias = Annotated[int, Unsigned("H", 2)]
DWORD: TypeAlias = Annotated[int, DOUBLE_WORD]
UINT: TypeAlias = int
HWND: TypeAlias = Any  # with .put(): a queue that messages are posted to
HANDLE: TypeAlias = Any  # with .set(): an event
LPVOID: TypeAlias = Annotated[Any, Pointer()]
LPBYTE: TypeAlias = Annotated[Any, Pointer()]
ACANCBFN: TypeAlias = Annotated[Callable[..., Any] | int | None, Pointer()]
REFERENCE: TypeAlias = Annotated[Any, Pointer(null=0)]  # a DWORD of the application's own, or anything
EIGHT_BYTES: TypeAlias = Annotated[bytes, Octets(8)]
TWO_BYTES: TypeAlias = Annotated[bytes, Octets(2)]


class Structure:
    """What all of them can. A field takes only what fits it: assigning anything else raises BadValue.

    `SIZE` in bytes; `OFFSETS` of the fields in memory, in their order.
    """

    __slots__ = ()
    SIZE: ClassVar[int]
    OFFSETS: ClassVar[dict[str, int]]
    _kinds: ClassVar[dict[str, Kind]]
    _layout: ClassVar[struct.Struct]

    def __setattr__(self, name: str, value: Any) -> None:
        kind = self._kinds.get(name)
        checked = kind.checked(f"{type(self).__name__}.{name}", value) if kind else value
        object.__setattr__(self, name, checked)

    def pack(self) -> bytes:
        """`SIZE` bytes of memory; raises BadValue for a pointer to a Python object."""
        return self._layout.pack(
            *[
                kind.packed(f"{type(self).__name__}.{name}", getattr(self, name))
                for name, kind in self._kinds.items()
            ]
        )

    @classmethod
    def unpack(cls, data: bytes | bytearray | memoryview) -> Self:
        """The structure in exactly `SIZE` bytes; raises BadValue for any other number."""
        if len(data) != cls.SIZE:
            raise BadValue(f"{cls.__name__} takes {cls.SIZE} bytes, not {len(data)}")
        items = zip(cls._kinds.items(), cls._layout.unpack(data), strict=True)
        return cls(**{name: kind.unpacked(item) for (name, kind), item in items})

    def assign(self, other: Self) -> None:
        """Take over every field of another one, as C's `*this = *other` does."""
        for field in dataclasses.fields(other):  # type: ignore[arg-type]
            setattr(self, field.name, getattr(other, field.name))


def lay_out(cls: type[Structure]) -> None:
    """Layout, size and offsets from the annotations; fields of other types have no place in memory."""
    hints = get_type_hints(cls, include_extras=True)
    cls._kinds = {
        field.name: hints[field.name].__metadata__[0]
        for field in dataclasses.fields(cls)  # type: ignore[arg-type]
        if hasattr(hints[field.name], "__metadata__")
    }
    cls.OFFSETS, size = {}, 0
    for name, kind in cls._kinds.items():
        cls.OFFSETS[name] = size
        size += struct.calcsize(f"<{kind.format}")
    cls._layout = struct.Struct("<" + "".join(kind.format for kind in cls._kinds.values()))
    cls.SIZE = size
