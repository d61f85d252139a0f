"""Structures whose fields take only what fits them, each declared by its annotations.

BYTE: TypeAlias = Annotated[int, number("B")]

@record()
class Pair(Record):
    first: BYTE = 0
    second: BYTE = 0

Pair.unpack(Pair(1, 2).pack()) == Pair(1, 2)
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, ClassVar, Self, TypeVar, dataclass_transform, get_type_hints

from canwire import BadValue
from canwire.packed.kinds import nested
from canwire.packed.layout import Kind, Layout, Misfit


class Record:
    """Base class of all structures. Assigning a value that does not fit its field raises BadValue, naming the field.

    `SIZE` in bytes; `OFFSETS` of the fields in memory, in their order.
    """

    __slots__ = ()
    SIZE: ClassVar[int]
    OFFSETS: ClassVar[dict[str, int]]
    _layout: ClassVar[Layout]

    def __setattr__(self, name: str, value: Any) -> None:
        kind = self._layout.kinds.get(name)
        if kind is not None:
            try:
                value = kind.fit(value)
            except Misfit as misfit:
                raise BadValue(f"{type(self).__name__}.{name}{misfit}") from None
        object.__setattr__(self, name, value)

    def pack(self) -> bytes:
        """`SIZE` bytes of memory, zeros in the gaps; raises BadValue for what has no place in memory."""
        try:
            return self._layout.pack(self)
        except Misfit as misfit:
            raise BadValue(f"{type(self).__name__}.{misfit}") from None

    @classmethod
    def unpack(cls, data: bytes | bytearray | memoryview) -> Self:
        """The structure in exactly `SIZE` bytes; raises BadValue for any other number."""
        memory = bytes(data)
        if len(memory) != cls.SIZE:
            raise BadValue(f"{cls.__name__} takes {cls.SIZE} bytes, not {len(memory)}")
        return cls(**dict(zip(cls._layout.kinds, cls._layout.unpack(memory), strict=True)))


R = TypeVar("R", bound=Record)


@dataclass_transform(field_specifiers=(dataclasses.field,))
def record(*, natural: bool = False, eq: bool = True) -> Callable[[type[R]], type[R]]:
    """Make a structure of a class whose annotations carry a Kind, or are such a structure themselves.

    Fields of other types have no place in memory. `natural` aligns each field to its own size, as compilers do.
    """

    def declare(cls: type[R]) -> type[R]:
        made: Any = dataclasses.dataclass(slots=True, eq=eq)(cls)
        hints = get_type_hints(made, include_extras=True)
        kinds = {field.name: _kind(hints[field.name]) for field in dataclasses.fields(made)}
        made._layout = Layout({name: kind for name, kind in kinds.items() if kind}, natural=natural)
        made.SIZE, made.OFFSETS = made._layout.size, made._layout.offsets
        return made

    return declare


def _kind(hint: Any) -> Kind | None:
    if isinstance(hint, type) and issubclass(hint, Record):
        return nested(hint, hint.SIZE, hint.pack, hint.unpack, hint._layout.align)
    return next((one for one in getattr(hint, "__metadata__", ()) if isinstance(one, Kind)), None)
