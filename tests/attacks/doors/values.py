"""What is put where something else belongs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

import canwire


class Bad(NamedTuple):
    """A value, and what a report calls it."""

    name: str
    value: Any


def numbers() -> list[Bad]:
    powers = [(f"2**{bits}", 2**bits) for bits in (31, 32, 63, 64, 70, 1100)]
    negative = [(f"-{name}", -value) for name, value in powers]
    odd = [
        ("-1", -1),
        ("65", 65),
        ("1.5", 1.5),
        ("1e300", 1e300),
        ("-1e-9", -1e-9),
        ("True", True),
        ("1j", 1j),
    ]
    unreal = [(text, float(text)) for text in ("nan", "inf", "-inf")]
    return [Bad(*each) for each in (*powers, *negative, *odd, *unreal)]


def buffers() -> list[Bad]:
    records = canwire.frames_to_array([canwire.Frame(1, b"x"), canwire.Frame(2), canwire.Frame(3)])
    frozen = records.copy()
    frozen.flags.writeable = False
    return [
        Bad("empty bytes", b""),
        Bad("5 bytes", b"\xff" * 5),
        Bad("a megabyte", b"\xff" * 1_000_000),
        Bad("bytearray", bytearray(b"\xfe" * 80)),
        Bad("memoryview", memoryview(b"\xfd" * 80)),
        Bad("strided memoryview", memoryview(b"\xfc" * 160)[::2]),
        Bad("zeros(3)", np.zeros(3)),
        Bad("records backwards", records[::-1]),
        Bad("read-only records", frozen),
        Bad("records in two dimensions", np.stack([records, records])),
        Bad("no records", records[:0]),
    ]


def objects() -> list[Bad]:
    nested: list[Any] = []
    nested.append(nested)
    return [
        Bad("None", None),
        Bad("empty text", ""),
        Bad("text", "hello"),
        Bad("text with a null", "can0\0"),
        Bad("lone surrogate", "\udcff"),
        Bad("long text", "x" * 100_000),
        Bad("object()", object()),
        Bad("a class", int),
        Bad("a function", len),
        Bad("[]", []),
        Bad("[1, 2]", [1, 2]),
        Bad("[None]", [None]),
        Bad("()", ()),
        Bad("(None, None)", (None, None)),
        Bad("{}", {}),
        Bad("a list in itself", nested),
        Bad("Frame", canwire.Frame(0x123, b"\x11")),
        Bad("the class Frame", canwire.Frame),
    ]


def bad_values() -> list[Bad]:
    """All of them, made anew: a call may have changed the last ones."""
    return [*objects(), *numbers(), *buffers()]
