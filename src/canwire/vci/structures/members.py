"""The members of C structures: their memory layout, and their values in Python.

Each function declares one member by its C name; structure.py collects them.
Source: VCI V4 headers (stdtype.h: fixed-width words, BOOL8 and BOOL32); reference/vci.md section 5.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any
from uuid import UUID

from canwire.packed import kinds
from canwire.packed.kinds import limited
from canwire.packed.layout import Kind


@dataclasses.dataclass(frozen=True, slots=True)
class Member:
    """A member's C name and its kind.

    A constructor applies `complete` to a value; `show` returns the text of a value.
    """

    c_name: str
    kind: Kind
    default: Callable[[], Any]
    complete: Callable[[Any], Any] | None = None
    show: Callable[[Any], str] = repr
    name: str = ""


def member(
    c_name: str,
    kind: Kind,
    default: Callable[[], Any],
    *,
    complete: Callable[[Any], Any] | None = None,
    show: Callable[[Any], str] = repr,
) -> Any:
    """A dataclass field with a Member of these arguments in its metadata."""
    made = Member(c_name, kind, default, complete, show)
    return dataclasses.field(default_factory=default, metadata={"member": made})


def _word(c_name: str, format: str, show: Callable[[Any], str] = repr) -> Any:
    return member(c_name, kinds.number(format), int, show=show)


def u8(c_name: str) -> Any:
    """UINT8."""
    return _word(c_name, "B")


def u16(c_name: str) -> Any:
    """UINT16."""
    return _word(c_name, "H")


def u32(c_name: str) -> Any:
    """UINT32."""
    return _word(c_name, "I")


def x16(c_name: str) -> Any:
    """UINT16 that is printed in hex."""
    return _word(c_name, "H", _show_hex)


def x32(c_name: str) -> Any:
    """UINT32 that is printed in hex."""
    return _word(c_name, "I", _show_hex)


def i64(c_name: str) -> Any:
    """INT64, printed in hex."""
    return _word(c_name, "q", _show_hex)


def bool8(c_name: str) -> Any:
    """BOOL8: each number except 0 is True."""
    return member(c_name, Kind("b", "True or False", decode=bool), bool)


def bool32(c_name: str) -> Any:
    """BOOL32: each number except 0 is True."""
    return member(c_name, Kind("i", "True or False", decode=bool), bool)


def octets(c_name: str, size: int) -> Any:
    """UINT8[size], as bytes; a shorter value is padded with zeros."""

    def complete(value: object) -> object:
        fits = isinstance(value, bytes | bytearray | memoryview)
        return bytes(value).ljust(size, b"\0") if fits else value  # type: ignore[call-overload]

    return member(c_name, kinds.octets(size), lambda: bytes(size), complete=complete, show=show_octets)


def data_field(size: int) -> Any:
    """abData, UINT8[size] that may be written byte by byte, as a bytearray."""
    return member("abData", kinds.octets(size, made=bytearray), lambda: bytearray(size), show=show_octets)


def text(c_name: str, size: int) -> Any:
    """CHAR[size] in Latin-1, ended by a NUL."""

    def encode(value: str) -> bytes:
        if "\0" in value:
            raise ValueError("a NUL ends the text")
        return limited(value.encode("latin-1"), size - 1)

    def decode(data: bytes) -> str:
        return data.partition(b"\0")[0].decode("latin-1")

    wants = f"at most {size - 1} characters of Latin-1"
    return member(c_name, Kind(f"{size}s", wants, encode=encode, decode=decode), str)


def guid(c_name: str) -> Any:
    """GUID: its first three fields are little-endian numbers."""
    kind = Kind(
        "16s",
        "a uuid.UUID",
        encode=lambda value: value.bytes_le,
        decode=lambda data: UUID(bytes_le=data),
    )
    return member(c_name, kind, lambda: UUID(int=0))


def words(c_name: str, count: int) -> Any:
    """UINT16[count], as a list; a shorter list is padded with zeros."""

    def complete(value: object) -> object:
        return [*value, *[0] * (count - len(value))] if isinstance(value, list | tuple) else value

    return member(
        c_name,
        kinds.numbers("H", count, made=list),
        lambda: [0] * count,
        complete=complete,
        show=lambda value: f"[{', '.join(map(_show_hex, _trimmed(value, 0)))}]",
    )


def nested(c_name: str, of: Any) -> Any:
    """A structure inside a structure."""
    return member(c_name, _inside(of), of)


def nested_array(c_name: str, of: Any, count: int) -> Any:
    """An array of structures, as a list; a shorter list is padded with empty structures."""
    one, size = _inside(of), of.SIZE

    def filled(value: Sequence[Any]) -> list[Any]:
        return [*value, *(of() for _ in range(count - len(value)))]

    def decode(data: bytes) -> list[Any]:
        return [of.from_bytes(data[at : at + size]) for at in range(0, len(data), size)]

    kind = Kind(
        f"{count * size}s",
        f"at most {count} times {of.__name__}",
        encode=lambda value: limited(b"".join(of.to_bytes(one.fit(item)) for item in value), count * size),
        decode=decode,
    )
    return member(
        c_name,
        kind,
        lambda: filled([]),
        complete=lambda value: filled(value) if isinstance(value, list | tuple) else value,
        show=lambda value: repr(_trimmed(value, of())),
    )


def show_octets(value: Any) -> str:
    """Bytes as an expression in hex, without the zeros at their end."""
    if not isinstance(value, bytes | bytearray):
        return repr(value)
    return f'bytes.fromhex("{bytes(value).rstrip(bytes(1)).hex()}")'


def _inside(of: Any) -> Kind:
    return kinds.nested(of, of.SIZE, of.to_bytes, of.from_bytes)


def _show_hex(value: Any) -> str:
    return hex(value) if isinstance(value, int) else repr(value)


def _trimmed(value: Sequence[Any], empty: Any) -> list[Any]:
    kept = len(value)
    while kept and value[kept - 1] == empty:
        kept -= 1
    return list(value[:kept])
