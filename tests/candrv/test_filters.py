"""Alignment and acceptance. Source: CANDRV manual, tables 5 and 6, 7.9, 8.11; rulings.md 19, 33a."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadFilter, BadFrame, Frame, candrv
from canwire.candrv import Filter
from canwire.candrv.filters import aligned, identifier_of
from canwire.values import acceptance_orders
from tests.effort import examples

dwords = st.integers(0, 0xFFFF_FFFF)
aligns = st.integers(0, 3)
bits = st.integers(0, 1)
standard = st.integers(0, 0x7FF)
extended = st.integers(0, 0x1FFF_FFFF)
data = st.binary(max_size=8)

# table 6: the bits of the word that bit 0 and the identifier's highest bit lie in
TABLE_6 = {  # align: (11-bit identifier, 11-bit filter, 29-bit identifier, 29-bit filter)
    0: ((10, 0), (31, 21), (28, 0), (31, 3)),
    1: ((10, 0), (10, 0), (10, 0), (10, 0)),
    2: ((28, 18), (28, 18), (28, 0), (28, 0)),
    3: ((31, 21), (31, 21), (31, 3), (31, 3)),
}


def oracle(code: int, mask: int, align: int, active: int, frame: tuple[int, bool, bytes]) -> bool:
    """Bit by bit, as tables 5 and 6 and the drawings of 7.9 say."""
    identifier, is_extended, payload = frame
    top, bottom = TABLE_6[align][3 if is_extended else 1]
    for place in range(29 if is_extended else 11):
        if bottom + place > top:  # align 1: the remaining bits of the identifier are zero
            if identifier >> place & 1:
                return False
            continue
        must_match = (mask >> bottom + place & 1) == active
        if must_match and identifier >> place & 1 != code >> bottom + place & 1:
            return False
    compared = (mask if active else ~mask) & 0xFFFF
    if not code & 0xFFFF and compared | 7 == 0xFFFF and compared & 7 in (0, 7):
        return True  # neither code nor mask names a data bit
    for place in range(0 if is_extended or align == 1 else 16):
        if len(payload) <= 1 - place // 8:
            continue
        byte = payload[1 - place // 8]
        must_match = (mask >> place & 1) == active
        if must_match and byte >> place % 8 & 1 != code >> place & 1:
            return False
    return True


@st.composite
def cases(draw: st.DrawFn) -> tuple[int, int, int, int, tuple[int, bool, bytes]]:
    """A filter and a frame that is often near it."""
    code, mask, align, active = draw(dwords), draw(dwords), draw(aligns), draw(bits)
    code &= draw(st.sampled_from([0xFFFF_FFFF, 0xFFFF_0000]))
    mask ^= draw(st.sampled_from([0, mask & 0xFFFF, ~mask & 0xFFFF, mask & 0xFFFF ^ 7]))
    is_extended = draw(st.booleans())
    identifier = draw(extended if is_extended else standard)
    payload = draw(data)
    if draw(st.booleans()):
        top, bottom = TABLE_6[align][3 if is_extended else 1]
        identifier = code >> bottom & (1 << top + 1 - bottom) - 1
        payload = (code & 0xFFFF).to_bytes(2, "big") + payload[:6]
    if draw(st.booleans()):
        identifier ^= 1 << draw(st.integers(0, 28 if is_extended else 10))
    return code, mask, align, active, (identifier, is_extended, payload)


@pytest.mark.conforms("FS-38", "FS-39", "FS-40")
@examples(100)
@given(case=cases())
def test_a_filter_accepts_what_the_tables_say(
    case: tuple[int, int, int, int, tuple[int, bool, bytes]],
) -> None:
    *settings, frame = case
    assert Filter(*settings).accepts(*frame) == oracle(*case)


@examples(100)
@given(case=cases())
def test_the_core_accepts_the_same(case: tuple[int, int, int, int, tuple[int, bool, bytes]]) -> None:
    """values/acceptance_orders.py has the same rule in another form."""
    code, mask, align, active, (identifier, is_extended, payload) = case
    frame = Frame(identifier, payload, extended=is_extended)
    core = acceptance_orders.candrv(code, mask, align, active, mode_2b=is_extended)
    assert core.accepts(frame) == Filter(code, mask, align, active).accepts(identifier, is_extended, payload)


@pytest.mark.conforms("FS-40")
@pytest.mark.finding("dialects 3")
@pytest.mark.parametrize(
    ("code", "mask", "align", "active"),
    [
        (0x120, 0x007, 1, 0),
        (0x24000000, 0x00E00000, 0, 0),
        (0x24000000, 0xFF1FFFF8, 0, 1),
    ],
)
def test_example_1_of_8_11(code: int, mask: int, align: int, active: int) -> None:
    """ "The same setting", three times, with any data: neither code nor mask names a data bit (ruling 33a)."""
    one = Filter(code, mask, align, active)
    for payload in (b"", b"\0", b"\0\0\x56", b"\x12\x34", b"\xff\xff"):
        assert [i for i in range(0x800) if one.accepts(i, False, payload)] == list(range(0x120, 0x128))
    assert one.bits(extended=False) == "00100100+++"


@pytest.mark.conforms("FS-41")
def test_example_2_of_8_11() -> None:
    one = Filter(0x00234500, 0x030000FF, align=2)
    for block in range(4):
        first = block << 24 | 0x00234500
        accepted = [i for i in range(first - 0x200, first + 0x300) if one.accepts(i, True)]
        assert accepted == list(range(first, first + 0x100))
    assert not one.accepts(0x04234500, True)
    assert one.bits(extended=True) == "000++" + "00100011" + "01000101" + "++++++++"


@pytest.mark.conforms("FS-12", "FS-39")
def test_fan_1_of_chapter_3() -> None:
    """ID 0x200 and 1 in the first data byte; the second may be anything."""
    fan = Filter(0x200 << 21 | 0x0100, 0x0000_00FF)
    assert fan.accepts(0x200, False, b"\x01\x00")
    assert fan.accepts(0x200, False, b"\x01\x01")
    assert not fan.accepts(0x200, False, b"\x02\x01")
    assert fan.accepts(0x200, False, b"")  # bytes that are not there are not compared
    assert not fan.accepts(0x201, False, b"\x01\x01")


@pytest.mark.conforms("FS-12")
def test_coded_identifiers_of_chapter_3() -> None:
    sensors = Filter(0b100_0000_0000, 0b011_1111_1111, align=1)
    assert all(sensors.accepts(i) == (i >= 0x400) for i in range(0x800))
    fan = Filter(0b011_1111_1010, 0b000_0000_0001, align=1)
    assert [i for i in range(0x800) if fan.accepts(i)] == [0b01111111010, 0b01111111011]


@pytest.mark.conforms("FS-19")
def test_the_defaults_accept_identifier_0_only() -> None:
    default = Filter()
    assert [i for i in range(0x800) if default.accepts(i)] == [0]
    assert default.accepts(0, False, b"\x12\x34")
    assert default.accepts(0, True)
    assert not default.accepts(1, True)


@pytest.mark.conforms("FS-19")
@given(align=aligns, active=bits, identifier=extended, payload=data)
def test_everything(align: int, active: int, identifier: int, payload: bytes) -> None:
    """What CanRead writes; with MaskActive 1 it is the other way round."""
    every = Filter.everything(align, active)
    assert every.accepts(identifier & 0x7FF, False, payload)
    assert every.accepts(identifier, True, payload) == (align != 1 or identifier <= 0x7FF)
    if not active:
        assert (every.code, every.mask) == (0, 0xFFFFFFFF)


@pytest.mark.conforms("FS-40")
@pytest.mark.parametrize("align", TABLE_6)
@pytest.mark.parametrize("is_extended", [False, True])
def test_identifiers_lie_as_in_table_6(align: int, is_extended: bool) -> None:
    top, bottom = TABLE_6[align][2 if is_extended else 0]
    highest = (1 << top + 1 - bottom) - 1
    assert aligned(highest, is_extended, align) == highest << bottom
    assert identifier_of(1 << top, is_extended, align) == 1 << top - bottom
    for wrong in [1 << place for place in range(33) if not bottom <= place <= top]:
        with pytest.raises(BadFrame, match=rf"bits {top}\.\.{bottom} with Align={align}"):
            identifier_of(wrong, is_extended, align)
    with pytest.raises(BadFrame):
        identifier_of(-1, is_extended, align)


@given(align=aligns, identifier=extended, is_extended=st.booleans())
def test_identifiers_come_back(align: int, identifier: int, is_extended: bool) -> None:
    identifier &= 0x1FFF_FFFF if is_extended and align != 1 else 0x7FF
    assert identifier_of(aligned(identifier, is_extended, align), is_extended, align) == identifier


@pytest.mark.conforms("FS-11")
def test_v1_placed_standard_and_extended_alike() -> None:
    """CanMode2B 0 with Align 1, CanMode2B 1 with Align 0: what a V1.x program wrote means the same."""
    assert identifier_of(0x731, False, 1) == 0x731
    assert Filter(0x120, 0x007, align=1).accepts(0x127)
    assert identifier_of(0x12345678, True, 0) == 0x12345678
    assert Filter(0x12345678 << 3, 0x7, align=0).accepts(0x12345678, True)


@pytest.mark.conforms("FS-37")
@given(code=dwords, mask=dwords, align=aligns, active=bits)
def test_code_and_mask_come_back_as_they_were(code: int, mask: int, align: int, active: int) -> None:
    structure = candrv.CAN_ACCEPTANCE_FILTER(code, mask)
    one = Filter.of(structure, align, active)
    assert one.to_structure() == structure
    assert eval(repr(one)) == one
    assert hash(one) == hash(Filter(code, mask, align, active))
    assert one != Filter(code ^ 1, mask, align, active)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((1 << 32, 0), "code"),
        ((-1, 0), "code"),
        ((0, 1 << 32), "mask"),
        ((0, "1"), "mask"),
        ((0, 0, 4), "Align"),
        ((0, 0, 0, 2), "MaskActive"),
    ],
)
def test_impossible_filters(arguments: tuple[int, ...], message: str) -> None:
    with pytest.raises(BadFilter, match=message):
        Filter(*arguments)
