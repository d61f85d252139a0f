"""Acceptance filters against the documents' examples and a slow reading of every bit order."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.errors import BadFilter
from canwire.values.acceptance import Acceptance, frame_key, list_key
from canwire.values.acceptance_orders import candrv, mcp2515, sja1000_basic, sja1000_dual, sja1000_single, vci
from canwire.values.frame import Frame
from tests.cases import each
from tests.effort import examples
from tests.tables.sja1000_acceptance import VECTORS


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    extended = draw(st.booleans())
    id = draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF))
    remote = draw(st.booleans())
    return Frame(id, b"" if remote else draw(st.binary(max_size=8)), extended=extended, remote=remote)


four = st.binary(min_size=4, max_size=4)
# masks that compare few bits, or else next to nothing would ever be accepted
sparse = st.one_of(four, st.lists(st.sampled_from([0, 0, 0, 1, 0x80]), min_size=4, max_size=4).map(bytes))
words = st.one_of(
    st.integers(0, 0xFFFFFFFF),
    st.lists(st.integers(0, 31), max_size=3).map(lambda b: sum(1 << i for i in set(b))),
)


def bits_of(value: int, width: int) -> str:
    return f"{value:0{width}b}"


def agrees(frame_bits: str, code_bits: str, care_bits: str) -> bool:
    """Bit by bit; a frame bit of `?` does not exist and agrees with everything."""
    assert len(frame_bits) == len(code_bits) == len(care_bits)
    return all(
        care == "0" or seen in ("?", wanted)
        for seen, wanted, care in zip(frame_bits, code_bits, care_bits, strict=True)
    )


def data_bits(frame: Frame, at: int) -> str:
    return bits_of(frame.data[at], 8) if at < len(frame.data) else "?" * 8


def test_the_key_is_laid_out_as_drawn() -> None:
    assert frame_key(Frame(0x123, b"\xab\xcd\xef")) == 0x123 << 17 | 0xABCD
    assert frame_key(Frame(0x123, b"\xab")) == 1 << 47 | 0x123 << 17 | 0xAB00
    assert frame_key(Frame(0x123)) == 3 << 46 | 0x123 << 17
    assert frame_key(Frame(0x7FF, remote=True, dlc=2)) == 3 << 46 | 0x7FF << 17 | 1 << 16
    assert frame_key(Frame(0x1FFFFFFF, b"\0\1", extended=True)) == 1 << 63 | 0x1FFFFFFF << 17 | 1
    assert list_key(Frame(0x123, remote=True)) == 0x247
    assert list_key(Frame(0x123, extended=True)) == 0x80000246


@given(frames())
def test_everything_and_nothing(frame: Frame) -> None:
    assert Acceptance.everything().accepts(frame)
    assert not Acceptance.nothing().accepts(frame)


@given(frames(), st.lists(st.tuples(st.integers(0, 0x7FF), st.integers(0, 0x7FF), st.booleans()), max_size=3))
def test_lab_filters_compare_identifiers_of_one_format(
    frame: Frame, filters: list[tuple[int, int, bool]]
) -> None:
    accepted = Acceptance.from_filters(filters).accepts(frame)

    assert accepted == any(
        frame.extended == extended and frame.id & mask == code & mask for code, mask, extended in filters
    )


@each(
    ("filters", "named"),
    [
        ([(0x800, 0x7FF)], r"\(2048, 2047\): code 0x800: .* 11 bits; add True"),
        ([(0x123, 0x7FF), (0, 0x1FFFFFFF)], "mask 0x1fffffff"),
        ([(1 << 29, 0, True)], "code 0x20000000: a whole number of 29 bits$"),
        ([(-1, 0)], "code -0x1"),
        ([(1.5, 0)], "code 1.5"),
        ([(1,)], r"filter \(1,\): give"),
        ([7], "filter 7: give"),
        (["12"], "filter '12': give"),
    ],
)
def test_a_bad_filter_is_named(filters: list[tuple[int, int]], named: str) -> None:
    with pytest.raises(BadFilter, match=named):
        Acceptance.from_filters(filters)


def test_bad_keys_and_registers_are_named() -> None:
    with pytest.raises(BadFilter, match="64 bits"):
        Acceptance(((1 << 64, 0),))
    with pytest.raises(BadFilter, match="32 bits"):
        Acceptance((), frozenset({1 << 32}))
    with pytest.raises(BadFilter, match="code 0x1000"):
        Acceptance.identifier_list([0x1000], extended=False)
    with pytest.raises(BadFilter, match="AMR b'': four bytes"):
        sja1000_single(bytes(4), b"")
    with pytest.raises(BadFilter, match="ACR 0x100"):
        sja1000_basic(0x100, 0)
    with pytest.raises(BadFilter, match="align 4"):
        candrv(0, 0, 4, 0, False)
    with pytest.raises(BadFilter, match="mask_active 2"):
        candrv(0, 0, 0, 2, False)
    with pytest.raises(BadFilter, match="mask 0x100000000"):
        vci(False, 0, 1 << 32)


@examples(100)
@given(frames(), st.lists(st.integers(0, 0xFFF)), st.lists(st.integers(0, 0x3FFFFFFF)))
def test_identifier_lists_join(frame: Frame, standard: list[int], extended: list[int]) -> None:
    joined = Acceptance.identifier_list(standard, extended=False) | Acceptance.identifier_list(
        extended, extended=True
    )
    for one in (frame, *(Frame(code >> 1, remote=bool(code & 1), extended=True) for code in extended)):
        wanted = extended if one.extended else standard
        assert joined.accepts(one) == (one.id << 1 | one.remote in wanted)


@examples(100)
@given(frames(), st.integers(0, 0x7FF), st.integers(0, 0x7FF))
def test_joined_filters_accept_what_either_does(frame: Frame, code: int, mask: int) -> None:
    one = Acceptance.from_filters([(code, mask)])
    other = Acceptance.identifier_list([frame.id << 1 & 0xFFF], extended=False)
    assert (one | other).accepts(frame) == (one.accepts(frame) or other.accepts(frame))
    assert one | one == one


def test_vci_example_registers_100_to_103_without_remote() -> None:
    """VCI V4 manual 5.2.4: code 001 0000 0000 0, mask 111 1111 1100 1."""
    example = vci(False, 0b001_0000_0000_0, 0b111_1111_1100_1)
    accepted = [id for id in range(0x800) if example.accepts(Frame(id))]
    assert accepted == [0x100, 0x101, 0x102, 0x103]
    assert not any(example.accepts(Frame(id, remote=True)) for id in range(0x800))
    assert not example.accepts(Frame(0x100, extended=True))


@given(frames())
def test_vci_all_and_none(frame: Frame) -> None:
    both = vci(False, 0, 0) | vci(True, 0, 0)  # CAN_ACC_CODE_ALL, CAN_ACC_MASK_ALL
    assert both.accepts(frame)
    none = vci(frame.extended, 0x80000000, 0xFFFFFFFF)  # CAN_ACC_CODE_NONE, CAN_ACC_MASK_NONE
    assert not none.accepts(frame)


@examples(100)
@given(frames(), st.booleans(), words, words)
def test_vci_compares_identifier_and_remote_bit(frame: Frame, extended: bool, code: int, mask: int) -> None:
    width = 30 if extended else 12
    seen = frame.id << 1 | frame.remote
    expected = (
        frame.extended == extended
        and not (code & mask) >> 31
        and (seen ^ code) & mask & ((1 << width) - 1) == 0
    )
    assert vci(extended, code, mask).accepts(frame) == expected


@each(
    ("mode", "acr", "amr", "id", "remote", "data", "accepted"),
    [row[1:] for row in VECTORS],
    ids=[row[0] for row in VECTORS],
)
def test_sja1000_vectors(
    mode: str, acr: str, amr: str, id: str, remote: bool, data: str, accepted: bool
) -> None:
    code, mask = bytes.fromhex(acr), bytes.fromhex(amr)
    frame = Frame(int(id, 16), bytes.fromhex(data), extended=len(id) == 8, remote=remote)
    if mode == "B":
        acceptance = sja1000_basic(code[0], mask[0])
    else:
        acceptance = (sja1000_single if mode == "S" else sja1000_dual)(code, mask)
    assert acceptance.accepts(frame) == accepted


@examples(100)
@given(frames(), four, sparse)
def test_sja1000_single_bit_by_bit(frame: Frame, acr: bytes, care: bytes) -> None:
    amr = bytes(byte ^ 0xFF for byte in care)
    if frame.extended:
        seen = bits_of(frame.id, 29) + str(int(frame.remote)) + "??"
    else:
        seen = (
            bits_of(frame.id, 11)
            + str(int(frame.remote))
            + "????"
            + data_bits(frame, 0)
            + data_bits(frame, 1)
        )
    expected = agrees(seen, bits_of(int.from_bytes(acr), 32), bits_of(int.from_bytes(care), 32))
    assert sja1000_single(acr, amr).accepts(frame) == expected


@examples(100)
@given(frames(), four, sparse)
def test_sja1000_dual_bit_by_bit(frame: Frame, acr: bytes, care: bytes) -> None:
    amr = bytes(byte ^ 0xFF for byte in care)
    code, cared = (bits_of(int.from_bytes(value), 32) for value in (acr, care))
    if frame.extended:
        first = second = bits_of(frame.id, 29)[:16]
        one = agrees(first, code[:16], cared[:16])
    else:
        first = second = bits_of(frame.id, 11) + str(int(frame.remote))
        byte = data_bits(frame, 0)
        one = agrees(first + byte, code[:16] + code[28:], cared[:16] + cared[28:])
    two = agrees(second, code[16 : 16 + len(second)], cared[16 : 16 + len(second)])
    assert sja1000_dual(acr, amr).accepts(frame) == (one or two)


@examples(100)
@given(frames(), words, st.lists(words, max_size=2))
def test_mcp2515_bit_by_bit(frame: Frame, mask: int, filters: list[int]) -> None:
    def matches(value: int) -> bool:
        code, care = bits_of(value, 32), bits_of(mask, 32)
        if frame.extended != (code[12] == "1"):  # EXIDE, SIDL bit 3
            return False
        if frame.extended:
            id = bits_of(frame.id, 29)
            seen = id[:11] + "???" + id[11:]
        else:
            data = (frame.data + b"\0\0")[:2]
            seen = bits_of(frame.id, 11) + "?????" + bits_of(int.from_bytes(data), 16)
        return agrees(seen, code, care)

    assert mcp2515(mask, filters).accepts(frame) == any(matches(value) for value in filters)


@pytest.mark.conforms("FS-40")
@each(
    ("code", "mask", "align", "mask_active"),
    [
        (0x120, 0x007, 1, 0),
        (0x24000000, 0x00E00000, 0, 0),
        (0x24000000, 0xFF1FFFF8, 0, 1),
    ],
)
@each("data", [b"", b"\0", b"\0\0", b"\x12\x34", b"\xff" * 8])
def test_candrv_example_1_accepts_120_to_127(
    code: int, mask: int, align: int, mask_active: int, data: bytes
) -> None:
    """With any data: neither code nor mask names a data bit (ruling 33a)."""
    acceptance = candrv(code, mask, align, mask_active, mode_2b=False)
    assert [id for id in range(0x800) if acceptance.accepts(Frame(id, data))] == list(range(0x120, 0x128))
    assert not acceptance.accepts(Frame(0x120, data, extended=True))


@pytest.mark.conforms("FS-41")
def test_candrv_example_2_accepts_four_blocks() -> None:
    acceptance = candrv(0x00234500, 0x030000FF, align=2, mask_active=0, mode_2b=True)
    for top in range(4):
        for low in (0x00, 0x01, 0x80, 0xFF):
            assert acceptance.accepts(Frame(top << 24 | 0x234500 | low, extended=True))
    for id in (0x04234500, 0x00234600, 0x002344FF, 0x00334500, 0x10234500):
        assert not acceptance.accepts(Frame(id, extended=True))
    assert not acceptance.accepts(Frame(0x500))


@pytest.mark.conforms("FS-38")
@examples(100)
@given(frames(), words, words, st.integers(0, 3), st.integers(0, 1))
def test_candrv_compares_identifiers(
    frame: Frame, code: int, mask: int, align: int, mask_active: int
) -> None:
    if align != 1 and not frame.extended:  # no data asked for
        mask = mask & ~0xFFFF if mask_active else mask | 0xFFFF
    place = {False: {0: 21, 1: 0, 2: 18, 3: 21}, True: {0: 3, 1: 0, 2: 0, 3: 3}}[frame.extended][align]
    care = mask if mask_active else mask ^ 0xFFFFFFFF
    if frame.extended and align == 1:
        code, care = code & 0x7FF, care & 0x7FF | 0xFFFFF800  # rulings.md 19
    expected = agrees(
        bits_of(frame.id, 29 if frame.extended else 11),
        bits_of(code >> place, 32)[-29 if frame.extended else -11 :],
        bits_of(care >> place, 32)[-29 if frame.extended else -11 :],
    )
    assert candrv(code, mask, align, mask_active, frame.extended).accepts(frame) == expected
    other = Frame(1, extended=not frame.extended)
    assert not candrv(code, mask, align, mask_active, frame.extended).accepts(other)


@pytest.mark.conforms("FS-39")
@each(("align", "code"), [(0, 0x20000000), (2, 0x04000000), (3, 0x20000000)])
def test_candrv_compares_two_data_bytes_of_standard_frames(align: int, code: int) -> None:
    acceptance = candrv(code | 0x1200, 0x000000FF, align, 0, mode_2b=False)
    assert acceptance.accepts(Frame(0x100, b"\x12\x77"))
    assert not acceptance.accepts(Frame(0x100, b"\x13\x77"))
    assert not acceptance.accepts(Frame(0x101, b"\x12\x77"))
    both = candrv(code | 0x1234, 0, align, 0, mode_2b=False)
    assert both.accepts(Frame(0x100, b"\x12\x34\x56"))
    assert not both.accepts(Frame(0x100, b"\x12\x35"))
    extended = candrv(0x1234 << 3 if align != 2 else 0x1234, 0, align, 0, mode_2b=True)
    assert extended.accepts(Frame(0x1234, b"\xff\xff", extended=True))
