"""How members of C structures lie in memory, and what they are in Python.

Each function declares one member by its C name; structure.py collects them.
Source: VCI V4 headers (stdtype.h: fixed-width words, BOOL8 and BOOL32); reference/vci.md section 5.
"""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Callable, Sequence
from typing import Any
from uuid import UUID


@dataclasses.dataclass(frozen=True, slots=True)
class Member:
    """One item of a `struct` format; `encode` and `decode` turn Python's value into it and back.

    `wants` says in words what fits. `complete` is what a constructor does to a value, `show` how it
    is printed.
    """

    c_name: str
    format: str
    wants: str
    default: Callable[[], Any]
    encode: Callable[[Any], Any] | None = None
    decode: Callable[[Any], Any] | None = None
    complete: Callable[[Any], Any] | None = None
    show: Callable[[Any], str] = repr
    name: str = ""


def member(**described: Any) -> Any:
    """A dataclass field with a Member of these arguments in its metadata."""
    made = Member(**described)
    return dataclasses.field(default_factory=made.default, metadata={"member": made})


def _word(c_name: str, format_: str, low: int, high: int, show: Callable[[Any], str] = repr) -> Any:
    return member(
        c_name=c_name, format=format_, wants=f"a whole number from {low} to {high}", default=int, show=show
    )


def u8(c_name: str) -> Any:
    """UINT8."""
    return _word(c_name, "B", 0, 0xFF)


def u16(c_name: str) -> Any:
    """UINT16."""
    return _word(c_name, "H", 0, 0xFFFF)


def u32(c_name: str) -> Any:
    """UINT32."""
    return _word(c_name, "I", 0, 0xFFFF_FFFF)


def x16(c_name: str) -> Any:
    """UINT16 that is printed in hex."""
    return _word(c_name, "H", 0, 0xFFFF, _show_hex)


def x32(c_name: str) -> Any:
    """UINT32 that is printed in hex."""
    return _word(c_name, "I", 0, 0xFFFF_FFFF, _show_hex)


def i64(c_name: str) -> Any:
    """INT64, printed in hex."""
    return _word(c_name, "q", -(1 << 63), (1 << 63) - 1, _show_hex)


def bool8(c_name: str) -> Any:
    """BOOL8: everything but 0 is True."""
    return member(c_name=c_name, format="b", wants="True or False", default=bool, decode=bool)


def bool32(c_name: str) -> Any:
    """BOOL32: everything but 0 is True."""
    return member(c_name=c_name, format="i", wants="True or False", default=bool, decode=bool)


def octets(c_name: str, size: int) -> Any:
    """UINT8[size], as bytes; fewer are filled up with zeros."""

    def complete(value: object) -> object:
        fits = isinstance(value, bytes | bytearray | memoryview)
        return bytes(value).ljust(size, b"\0") if fits else value  # type: ignore[call-overload]

    return member(
        c_name=c_name,
        format=f"{size}s",
        wants=f"at most {size} bytes",
        default=lambda: bytes(size),
        encode=lambda value: limited(value, size),
        complete=complete,
        show=show_octets,
    )


def text(c_name: str, size: int) -> Any:
    """CHAR[size] in Latin-1, ended by a NUL."""

    def encode(value: str) -> bytes:
        if "\0" in value:
            raise ValueError("a NUL ends the text")
        return limited(value.encode("latin-1"), size - 1)

    return member(
        c_name=c_name,
        format=f"{size}s",
        wants=f"at most {size - 1} characters of Latin-1",
        default=str,
        encode=encode,
        decode=lambda raw: raw.partition(b"\0")[0].decode("latin-1"),
    )


def guid(c_name: str) -> Any:
    """GUID: its first three fields are little-endian numbers."""
    return member(
        c_name=c_name,
        format="16s",
        wants="a uuid.UUID",
        default=lambda: UUID(int=0),
        encode=lambda value: value.bytes_le,
        decode=lambda raw: UUID(bytes_le=raw),
    )


def words(c_name: str, count: int) -> Any:
    """UINT16[count], as a list; fewer are filled up with zeros."""
    layout = struct.Struct(f"<{count}H")

    def complete(value: Sequence[int]) -> list[int]:
        return [*value, *[0] * (count - len(value))]

    return member(
        c_name=c_name,
        format=f"{layout.size}s",
        wants=f"at most {count} whole numbers from 0 to 65535",
        default=lambda: [0] * count,
        encode=lambda value: layout.pack(*complete(value)),
        decode=lambda raw: list(layout.unpack(raw)),
        complete=lambda value: complete(value) if isinstance(value, list | tuple) else value,
        show=lambda value: f"[{', '.join(map(_show_hex, _trimmed(value, 0)))}]",
    )


def nested(c_name: str, kind: Any) -> Any:
    """A structure inside a structure."""
    return member(
        c_name=c_name,
        format=f"{kind.SIZE}s",
        wants=f"a {kind.__name__}",
        default=kind,
        encode=lambda value: _packed(value, kind),
        decode=kind.from_bytes,
    )


def nested_array(c_name: str, kind: Any, count: int) -> Any:
    """An array of structures, as a list; fewer are filled up with empty ones."""

    def complete(value: Sequence[Any]) -> list[Any]:
        return [*value, *(kind() for _ in range(count - len(value)))]

    def decode(raw: bytes) -> list[Any]:
        return [kind.from_bytes(raw[at : at + kind.SIZE]) for at in range(0, len(raw), kind.SIZE)]

    return member(
        c_name=c_name,
        format=f"{count * kind.SIZE}s",
        wants=f"at most {count} times {kind.__name__}",
        default=lambda: complete([]),
        encode=lambda value: limited(b"".join(_packed(one, kind) for one in value), count * kind.SIZE),
        decode=decode,
        complete=lambda value: complete(value) if isinstance(value, list | tuple) else value,
        show=lambda value: repr(_trimmed(value, kind())),
    )


def limited(value: Any, size: int) -> bytes:
    """The bytes of any buffer; ValueError if there are more than `size`, TypeError if it is none."""
    raw = bytes(memoryview(value))
    if len(raw) > size:
        raise ValueError(f"more than {size} bytes")
    return raw


def show_octets(value: Any) -> str:
    """Bytes as an expression in hex, without the zeros at their end."""
    if not isinstance(value, bytes | bytearray):
        return repr(value)
    return f'bytes.fromhex("{bytes(value).rstrip(bytes(1)).hex()}")'


def _packed(value: Any, kind: Any) -> bytes:
    if not isinstance(value, kind):
        raise TypeError(f"not a {kind.__name__}")
    packed: bytes = value.to_bytes()
    return packed


def _show_hex(value: Any) -> str:
    return hex(value) if isinstance(value, int) else repr(value)


def _trimmed(value: Sequence[Any], empty: Any) -> list[Any]:
    kept = len(value)
    while kept and value[kept - 1] == empty:
        kept -= 1
    return list(value[:kept])
