"""The kinds of field that more than one dialect's structures have.

Text stays with each: Latin-1 and UTF-16 end and overflow in different ways.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from canwire.packed.layout import Kind, Misfit


def number(format: str, wants: str = "") -> Kind:
    """A whole number, in the struct module's letter for it: B, H, I, Q, or b, h, i, q with a sign."""
    size = struct.calcsize(f"<{format}")
    low, high = _bounds(format)
    words = wants or f"a whole number from {low} to {high}"

    def fit(value: Any) -> int:
        if not isinstance(value, int) or not low <= value <= high:
            raise Misfit(value, words)
        return value

    return Kind(format, words, fit, align=size)


def numbers(format: str, count: int, made: Callable[[Iterable[int]], Any] = tuple) -> Kind:
    """An array of whole numbers as a tuple, or as what `made` makes; fewer are filled up with zeros."""
    one = number(format)
    layout = struct.Struct(f"<{count}{format}")
    low, high = _bounds(format)

    def filled(value: Sequence[int]) -> list[int]:
        return [*value, *[0] * (count - len(value))]

    def fit(value: Any) -> Any:
        given = tuple(value) if isinstance(value, Iterable) else (value,)
        if len(given) > count:
            raise Misfit(given, f"at most {count} numbers")
        for at, item in enumerate(given):
            if not isinstance(item, int) or not low <= item <= high:
                raise Misfit(item, one.wants, f"[{at}]")
        return made(filled(given))

    return Kind(
        f"{layout.size}s",
        f"at most {count} whole numbers from {low} to {high}",
        fit,
        encode=lambda value: layout.pack(*filled(value)),
        decode=lambda data: made(layout.unpack(data)),
        align=one.align,
    )


def octets(size: int, made: Callable[[bytes], Any] | None = None) -> Kind:
    """Bytes, as `made` makes them; fewer are filled up with zeros."""
    wants = f"at most {size} bytes"

    def fit(value: Any) -> bytes:
        if not isinstance(value, bytes | bytearray | memoryview) or len(bytes(value)) > size:
            raise Misfit(value, wants)
        return bytes(value).ljust(size, b"\0")

    return Kind(f"{size}s", wants, fit, encode=lambda value: limited(value, size), decode=made)


def nested(
    of: type, size: int, pack: Callable[[Any], bytes], unpack: Callable[[bytes], Any], align: int = 1
) -> Kind:
    """A structure inside another, and how it becomes `size` bytes and comes back."""
    wants = f"a {of.__name__}"

    def fit(value: Any) -> Any:
        if not isinstance(value, of):
            raise Misfit(value, wants)
        return value

    return Kind(f"{size}s", wants, fit, lambda value: pack(fit(value)), unpack, align)


def limited(value: Any, size: int) -> bytes:
    """The bytes of any buffer; ValueError if there are more than `size`, TypeError if it is none."""
    raw = bytes(memoryview(value))
    if len(raw) > size:
        raise ValueError(f"more than {size} bytes")
    return raw


def _bounds(format: str) -> tuple[int, int]:
    bits = 8 * struct.calcsize(f"<{format}")
    return (0, (1 << bits) - 1) if format.isupper() else (-(1 << bits - 1), (1 << bits - 1) - 1)
