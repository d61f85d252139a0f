"""The structures lie in memory as the manual's 16-bit headers say. Source: INduCAN104 manual, "Data structures"."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue, acan
from tests.cases import each

# C's declarations, in bytes; pointers are far
BYTE, WORD, DWORD, POINTER = 1, 2, 4, 4
FIELDS = {
    acan.ACANHI: {
        **dict.fromkeys(("hi_miv", "hi_mim", "hi_biv", "hi_bim"), DWORD),
        **dict.fromkeys(("hi_clk", "hi_rat"), WORD),
        **dict.fromkeys(("hi_ts1", "hi_ts2", "hi_sjw", "hi_msi"), BYTE),
        "hi_hsb": 8,
    },
    acan.ACANMB: {"dwID": DWORD, "bFormat": BYTE, "bLength": BYTE, "bData": 8},
    acan.ACANID: {
        "dwAnd": DWORD,
        "dwXor": DWORD,
        "bAction": BYTE,
        "bLength": BYTE,
        "bReserved": 2,
        "lpAddress": POINTER,
    },
    acan.ACANTB: {
        "dwReserved0": DWORD,
        "wTid": WORD,
        "wEvent": WORD,
        "cbNotification": POINTER,
        "dwRefData": DWORD,
        "bNotType": BYTE,
        "bSCFilter": BYTE,
        "wStatus": WORD,
        "bREC": BYTE,
        "bTEC": BYTE,
        "bALC": BYTE,
        "bECC": BYTE,
        "lpRMB": POINTER,
        "wRMBSize": WORD,
        "wRMBOccupation": WORD,
        "wRIndex": WORD,
        "wWIndex": WORD,
        "lpBuf": POINTER,
        "wCount": WORD,
        "bNId": BYTE,
        "bReserved0": BYTE,
        "dwReserved1": DWORD,
        "dwReserved2": DWORD,
        "dwReserved3": DWORD,
        "dwFree": DWORD,
        "dwReserved4": DWORD,
    },
}
SIZES = {acan.ACANHI: 32, acan.ACANMB: 14, acan.ACANID: 16, acan.ACANTB: 64}
BYTES = {"hi_hsb": 8, "bData": 8, "bReserved": 2}
ONE_BY_ONE = [(cls, name, size) for cls, fields in FIELDS.items() for name, size in fields.items()]
each_field = pytest.mark.parametrize(
    ("cls", "name", "size"), ONE_BY_ONE, ids=[f"{cls.__name__}.{name}" for cls, name, _ in ONE_BY_ONE]
)


def structures(cls: type) -> st.SearchStrategy[Any]:
    return st.builds(
        cls,
        **{
            name: st.binary(max_size=size)
            if name in BYTES
            else st.integers(1 if name in {"bNId"} else 0, (1 << 8 * size) - 1)
            for name, size in FIELDS[cls].items()
            if name != "bNId"
        },
    )


@pytest.mark.conforms("AC-37", "AC-38")
@each("cls", FIELDS)
def test_fields_lie_in_their_order_without_gaps(cls: type) -> None:
    expected, at = {}, 0
    for name, size in FIELDS[cls].items():
        expected[name] = at
        at += size
    assert expected == cls.OFFSETS
    assert list(expected) == list(cls.OFFSETS)
    assert cls.SIZE == at == SIZES[cls]


@pytest.mark.finding("acan A15.4")
def test_the_manuals_sizes() -> None:
    assert (acan.ACANMBSZ, acan.ACANIDSZ, acan.ACANTBSZ) == (14, 16, 64)
    assert acan.ACANHISZ == 32


@each_field
def test_each_field_little_endian_where_it_belongs(cls: type, name: str, size: int) -> None:
    value = bytes(range(0x81, 0x81 + size))
    one = cls(**{name: value if name in BYTES else int.from_bytes(value, "little")})
    if name == "bNId":
        one.idTable = [acan.ACANID()] * value[0]
    packed = one.pack()[: cls.SIZE]
    at = cls.OFFSETS[name]
    assert packed == bytes(at) + value + bytes(cls.SIZE - at - size)


@each_field
def test_what_does_not_fit_is_refused_by_name(cls: type, name: str, size: int) -> None:
    wrong = [bytes(size + 1), "x", 3] if name in BYTES else [-1, 1 << 8 * size]
    for value in wrong:
        with pytest.raises(BadValue, match=rf"{cls.__name__}\.{name} "):
            cls(**{name: value})
        one = cls()
        with pytest.raises(BadValue, match=rf"{cls.__name__}\.{name} "):
            setattr(one, name, value)
        assert one.pack() == cls().pack()


@pytest.mark.parametrize("cls", [acan.ACANHI, acan.ACANMB, acan.ACANID])
@given(data=st.data())
def test_round_trip(cls: type, data: st.DataObject) -> None:
    one = data.draw(structures(cls))
    packed = one.pack()
    assert len(packed) == cls.SIZE
    assert cls.unpack(packed).pack() == packed
    if cls is not acan.ACANID or one.lpAddress:  # 0 is NULL, and NULL is None
        assert cls.unpack(packed) == one


@given(block=structures(acan.ACANTB), filters=st.lists(structures(acan.ACANID), max_size=4))
def test_round_trip_of_a_task_block_with_its_filters(block: acan.ACANTB, filters: list[acan.ACANID]) -> None:
    block.idTable, block.bNId = filters, len(filters)
    packed = block.pack()
    assert len(packed) == acan.ACANTBSZ + len(filters) * acan.ACANIDSZ
    again = acan.ACANTB.unpack(packed)
    assert again.pack() == packed
    assert [one.pack() for one in again.idTable] == [one.pack() for one in filters]


@each("cls", FIELDS)
@each("more", [-1, 1])
def test_other_sizes_are_refused(cls: type, more: int) -> None:
    with pytest.raises(BadValue, match=cls.__name__):
        cls.unpack(bytes(cls.SIZE + more))


@given(data=st.binary(max_size=300))
def test_any_bytes_are_a_task_block_or_bad(data: bytes) -> None:
    try:
        block = acan.ACANTB.unpack(data)
    except BadValue:
        return
    assert block.pack() == data


def test_filters_count_themselves_unless_told_otherwise() -> None:
    filters = [acan.ACANID(), acan.ACANID(dwAnd=1)]
    assert acan.ACANTB(idTable=filters).bNId == 2
    only_one = acan.ACANTB(idTable=filters, bNId=1)
    assert len(only_one.pack()) == acan.ACANTBSZ + acan.ACANIDSZ
    with pytest.raises(BadValue, match="bNId is 3"):
        acan.ACANTB(idTable=filters, bNId=3).pack()


def test_pointers_to_python_objects_have_no_place_in_memory() -> None:
    one = acan.ACANID(lpAddress=bytearray(8))
    with pytest.raises(BadValue, match=r"ACANID\.lpAddress .* far pointer"):
        one.pack()
    assert acan.ACANID().pack()[-4:] == bytes(4)
    assert acan.ACANID.unpack(bytes(16)).lpAddress is None


def test_the_two_names_in_the_controllers_bytes() -> None:
    hi = acan.ACANHI(hi_hsb=bytes([1, 2, 3]))
    hi.hi_ocr, hi.hi_ien = 0x6A, 0xAD
    assert hi.hi_hsb == bytes([0x6A, 0xAD, 3, 0, 0, 0, 0, 0])
    assert (hi.hi_ocr, hi.hi_ien) == (0x6A, 0xAD)
    with pytest.raises(BadValue, match="hi_ien is 256"):
        hi.hi_ien = 256


def test_assign_fills_a_structure_in_where_it_is() -> None:
    mine, other = acan.ACANHI(), acan.ACANHI(hi_clk=16_000, hi_hsb=b"\x6a")
    mine.assign(other)
    assert mine == other
    other.hi_clk = 1
    assert mine.hi_clk == 16_000


def test_a_task_block_is_its_place() -> None:
    one, other = acan.ACANTB(), acan.ACANTB()
    assert one != other
    assert len({one, other}) == 2


@pytest.mark.conforms("AC-20")
@each(
    ("dw_and", "dw_xor", "passes", "stops"),
    [
        (0x00000000, 0x00000000, [0, 0x1FFFFFFF, 0x048 << 18], []),
        (0x1FFFFFFF, 0x12345678, [0x12345678], [0x12345679, 0x02345678]),
        (0x1FFF0000, 0x01C00000, [0x01C00000, 0x01C0FFFF], [0x01C10000, 0x01BFFFFF, 0x11C00000]),
    ],
)
def test_filters_of_the_manual(dw_and: int, dw_xor: int, passes: list[int], stops: list[int]) -> None:
    """Source: manual, "Here are a few filter examples"."""
    one = acan.ACANID(dwAnd=dw_and, dwXor=dw_xor)
    assert all(one.passes(word) for word in passes)
    assert not any(one.passes(word) for word in stops)


@pytest.mark.conforms("AC-20")
@given(word=st.integers(0, 0x1FFFFFFF), dw_and=st.integers(0, 0xFFFFFFFF), dw_xor=st.integers(0, 0xFFFFFFFF))
def test_a_filter_ands_then_xors(word: int, dw_and: int, dw_xor: int) -> None:
    assert acan.ACANID(dw_and, dw_xor).passes(word) == ((word & dw_and) ^ dw_xor == 0)
    assert acan.ACANID(dw_and, word & dw_and).passes(word)
