"""The C types of ACAN.H's structures, as annotations of their fields.

Source: INduCAN104 manual, "Programming interface" (definitions).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, TypeAlias

from canwire.packed.kinds import number, octets
from canwire.packed.layout import Kind, Misfit


def _unsigned(format: str, largest: int) -> Kind:
    return number(format, f"a whole number from 0 to 0x{largest:X}")


ONE_BYTE = _unsigned("B", 0xFF)
_DOUBLE_WORD = _unsigned("I", 0xFFFF_FFFF)


def _pointer(null: Any = None) -> Kind:
    """A far pointer, segment << 16 | offset, or in Python the object pointed to; NULL is `null` in Python."""

    def fit(value: Any) -> Any:
        return _DOUBLE_WORD.fit(value) if isinstance(value, int) else value

    def encode(value: Any) -> Any:
        if value is not None and not isinstance(value, int):
            raise Misfit(value, "only a far pointer has a place in memory")
        return value or 0

    return Kind("I", "a far pointer", fit, encode, lambda address: address or null, align=4)


BOOL: TypeAlias = bool
BYTE: TypeAlias = Annotated[int, ONE_BYTE]
WORD: TypeAlias = Annotated[int, _unsigned("H", 0xFFFF)]
DWORD: TypeAlias = Annotated[int, _DOUBLE_WORD]
UINT: TypeAlias = int
HWND: TypeAlias = Any  # with .put(): a queue that messages are posted to
HANDLE: TypeAlias = Any  # with .set(): an event
LPVOID: TypeAlias = Annotated[Any, _pointer()]
LPBYTE: TypeAlias = Annotated[Any, _pointer()]
ACANCBFN: TypeAlias = Annotated[Callable[..., Any] | int | None, _pointer()]
REFERENCE: TypeAlias = Annotated[Any, _pointer(null=0)]  # the application's DWORD, or any object
EIGHT_BYTES: TypeAlias = Annotated[bytes, octets(8)]
TWO_BYTES: TypeAlias = Annotated[bytes, octets(2)]
