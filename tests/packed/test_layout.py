"""Packed and aligned structures lie in memory as a compiler puts them; what does not fit is refused by name."""

from __future__ import annotations

import ctypes
import dataclasses
from typing import Annotated, Any, TypeAlias

import pytest

from canwire import BadValue, acan, candrv, vci
from canwire.packed.kinds import number, numbers, octets
from canwire.packed.layout import Kind, Layout, Misfit
from canwire.packed.record import Record, record
from tests.cases import each

BYTE: TypeAlias = Annotated[int, number("B")]
WORD: TypeAlias = Annotated[int, number("h")]
LONG: TypeAlias = Annotated[int, number("Q")]
THREE_WORDS: TypeAlias = Annotated[tuple[int, ...], numbers("H", 3)]
HUGE = 10**5000  # Python prints no number of so many digits


@record(natural=True)
class Inner(Record):
    first: BYTE = 0
    second: WORD = 0


@record(natural=True)
class Outer(Record):
    first: BYTE = 0
    inner: Inner = dataclasses.field(default_factory=Inner)
    words: THREE_WORDS = (0, 0, 0)
    long: LONG = 0
    last: BYTE = 0


class CInner(ctypes.LittleEndianStructure):
    _fields_ = [("first", ctypes.c_uint8), ("second", ctypes.c_int16)]


class COuter(ctypes.LittleEndianStructure):
    _fields_ = [
        *(("first", ctypes.c_uint8), ("inner", CInner), ("words", ctypes.c_uint16 * 3)),
        *(("long", ctypes.c_uint64), ("last", ctypes.c_uint8)),
    ]


@pytest.mark.parametrize(("mine", "compiled"), [(Inner, CInner), (Outer, COuter)])
def test_natural_alignment_is_a_compilers(mine: type[Record], compiled: type[ctypes.Structure]) -> None:
    assert ctypes.sizeof(compiled) == mine.SIZE
    assert {name: getattr(compiled, name).offset for name, *_ in compiled._fields_} == mine.OFFSETS


def test_a_compiler_reads_the_same_fields() -> None:
    made = Outer(1, Inner(2, -3), (4, 5), 6, 7)
    read = COuter.from_buffer_copy(made.pack())
    assert (read.first, read.inner.first, read.inner.second) == (1, 2, -3)
    assert (list(read.words), read.long, read.last) == ([4, 5, 0], 6, 7)
    assert Outer.unpack(bytes(read)) == made


def test_packed_has_no_gaps() -> None:
    layout = Layout({"first": number("B"), "second": number("H"), "third": octets(3)})
    assert (layout.size, layout.offsets, layout.align) == (6, {"first": 0, "second": 1, "third": 3}, 1)


@each(
    ("name", "value", "text"),
    [
        ("first", 256, r"Outer\.first is 256: a whole number from 0 to 255"),
        ("words", [1, 2, -1], r"Outer\.words\[2\] is -1: a whole number from 0 to 65535"),
        ("words", [1, 2, 3, 4], r"Outer\.words is \(1, 2, 3, 4\): at most 3 numbers"),
        ("inner", CInner(), r"Outer\.inner is .*: a Inner"),
        pytest.param("long", HUGE, r"Outer\.long is out of all range", id="long-huge"),
    ],
)
def test_what_does_not_fit_is_refused_when_assigned(name: str, value: Any, text: str) -> None:
    one = Outer()
    with pytest.raises(BadValue, match=text):
        setattr(one, name, value)
    assert one == Outer()


class Loose:
    """Fields that nobody checked."""

    first: Any = 1
    second: Any = 2


def test_what_does_not_fit_is_named_when_packed() -> None:
    layout = Layout({"first": number("B"), "second": Kind("4s", "text", encode=lambda value: value.encode())})
    loose = Loose()
    with pytest.raises(Misfit, match="second is 2: text"):
        layout.pack(loose)
    loose.second = "abc"
    assert layout.pack(loose) == b"\x01abc\0"
    loose.first = 256
    with pytest.raises(Misfit, match="first is 256: a whole number from 0 to 255"):
        layout.pack(loose)


@pytest.mark.parametrize("made", [acan.ACANMB, candrv.CAN_TRANSMIT_DATA])
def test_a_number_that_python_does_not_print_is_a_bad_value(made: type) -> None:
    """It was a ValueError of Python's own."""
    name = next(iter(made.OFFSETS))  # type: ignore[attr-defined]
    with pytest.raises(BadValue, match=rf"{made.__name__}\.{name} is out of all range"):
        made(**{name: HUGE})


def test_the_three_dialects_declare_over_the_same_layout() -> None:
    one = vci.CanBtp(mode=1, bps=2, ts1=3)
    assert one.to_bytes()[:8] == bytes.fromhex("01000000 02000000")
    assert acan.ACANMB(dwID=1, bLength=2).pack()[:6] == bytes.fromhex("01000000 00 02")
    assert candrv.CAN_TRANSMIT_DATA(identifier=1, dlc=2).pack()[4:10] == bytes.fromhex("01000000 00 02")
