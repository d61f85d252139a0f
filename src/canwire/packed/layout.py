"""The places of a C structure's fields, and the conversion of their values to memory and back."""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Callable, Iterable, Mapping
from typing import Any

_MISFITS = (struct.error, TypeError, ValueError, AttributeError)


@dataclasses.dataclass(frozen=True, slots=True)
class Kind:
    """A kind of field: one item of a `struct` format.

    `wants` says in words what fits. `fit` gives what the field holds for a value, or raises Misfit.
    `encode` makes the item that lies in memory of what it holds, `decode` the other way round; None: it is the same.
    `align` in bytes counts where a structure is aligned naturally.
    """

    format: str
    wants: str
    fit: Callable[[Any], Any] = lambda value: value
    encode: Callable[[Any], Any] | None = None
    decode: Callable[[Any], Any] | None = None
    align: int = 1

    @property
    def size(self) -> int:
        """Bytes in memory."""
        return struct.calcsize(f"<{self.format}")


class Misfit(ValueError):
    """A value that a field cannot hold; its text follows the name of the structure. `name` may be of a part, "[3]"."""

    def __init__(self, value: object, wants: str, name: str = "") -> None:
        super().__init__(value, wants, name)  # pickle calls `__init__` with these arguments
        self.value = value
        self.wants = wants
        self.name = name

    def __str__(self) -> str:
        return f"{self.name} is {brief(self.value)}: {self.wants}"


class Layout:
    """Fields in their order, little-endian: one after the other, or aligned as compilers do (`natural`).

    `size` and `offsets` in bytes; `align` is what a structure asks for that has this one inside.
    """

    def __init__(self, kinds: Mapping[str, Kind], *, natural: bool = False) -> None:
        self.kinds = dict(kinds)
        self.align = max((kind.align for kind in kinds.values()), default=1) if natural else 1
        self.offsets: dict[str, int] = {}
        items, end = "<", 0
        for name, kind in kinds.items():
            gap = -end % kind.align if natural else 0
            self.offsets[name] = end + gap
            items += f"{gap}x{kind.format}"
            end += gap + kind.size
        self.struct = struct.Struct(f"{items}{-end % self.align}x")
        self.size = self.struct.size
        self._encoders = tuple((name, kind.encode) for name, kind in kinds.items())
        self._decoders = tuple(kind.decode for kind in kinds.values())

    def pack(self, record: object) -> bytes:
        """`size` bytes; gaps are zero. Raises Misfit, with its name, for the first field that does not fit."""
        try:
            return self.struct.pack(
                *[
                    encode(getattr(record, name)) if encode else getattr(record, name)
                    for name, encode in self._encoders
                ]
            )
        except _MISFITS as error:
            raise self._misfit(record) or error from None

    def unpack(self, data: bytes | bytearray | memoryview) -> list[Any]:
        """The fields' values in exactly `size` bytes; raises struct.error or TypeError for anything else."""
        return self.decoded(self.struct.unpack(data))

    def decoded(self, items: Iterable[Any]) -> list[Any]:
        """The fields' values of what `struct` unpacked."""
        return [decode(item) if decode else item for decode, item in zip(self._decoders, items, strict=True)]

    def _misfit(self, record: object) -> Misfit | None:
        for name, kind in self.kinds.items():
            value = getattr(record, name, None)
            try:
                struct.pack(f"<{kind.format}", kind.encode(value) if kind.encode else value)
            except Misfit as misfit:
                return Misfit(misfit.value, misfit.wants, name + misfit.name)
            except _MISFITS:
                return Misfit(value, kind.wants, name)
        return None


def brief(value: object, longest: int = 40) -> str:
    """A value as text for an error message, shortened to a maximum number of characters."""
    try:
        return f"{value!r:.{longest}}"
    except ValueError:  # Python prints no whole number of thousands of digits
        return "out of all range"
