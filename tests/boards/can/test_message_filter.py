"""VCI's two-stage filter against a slow reading of the manual's words. Source: VCI V4 manual 5.2.4."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadFilter, NotInitialised
from canwire.boards.can.message_filter import (
    ALWAYS,
    BY_LIST,
    BY_PATTERN,
    LARGEST_LIST,
    NOT_EXCLUDED,
    REJECTED,
    FormatFilter,
    MessageFilter,
    message_filter,
)
from canwire.boards.can.modes import FilterMode
from tests.cases import each
from tests.effort import examples

pytestmark = pytest.mark.core

LOCK, PASS, INCL, EXCL = FilterMode.LOCK, FilterMode.PASS, FilterMode.INCLUSIVE, FilterMode.EXCLUSIVE
MODES = [LOCK, PASS, INCL, EXCL]
CODE_ALL, MASK_ALL, CODE_NONE, MASK_NONE = 0, 0, 0x80000000, 0xFFFFFFFF  # CAN_ACC_CODE_ and CAN_ACC_MASK_
WIDTH = {False: 12, True: 30}
EVERYTHING = {False: range(1 << 12), True: range(0)}  # of 2**30 values nobody looks at each


def head(id: int, *, remote: bool = False, extended: bool = False, more: int = 0) -> int:
    """The id/info word of a frame's record."""
    return id | ((1 << 22 if remote else 0) | (1 << 23 if extended else 0) | more) << 32


def passing(filter: MessageFilter, *, extended: bool = False) -> dict[int, int]:
    """Of all 11-bit frames (or the first 4096 values of 29-bit ones) those that pass, as id << 1 | remote."""
    heads = ((value, head(value >> 1, remote=bool(value & 1), extended=extended)) for value in range(4096))
    return {value: code for value, word in heads if (code := filter.judge(word))}


def both(mode: int, size: int = 2048) -> MessageFilter:
    return message_filter(mode, size, mode, size)


# what a filter just made does


@pytest.mark.conforms("X4-34", "X4-33")
@each("extended", [False, True])
@each(("mode", "code"), [(LOCK, REJECTED), (PASS, ALWAYS), (INCL, BY_PATTERN), (EXCL, NOT_EXCLUDED)])
def test_just_made_everything_passes_but_for_lock(mode: FilterMode, code: int, extended: bool) -> None:
    """X3-28: after an initialisation everything passes."""
    expected = {} if code == REJECTED else dict.fromkeys(range(4096), code)
    assert passing(both(mode), extended=extended) == expected


def test_the_acceptance_codes_are_those_of_vci() -> None:
    """reference/vci.md section 3, CAN_ACCEPT_."""
    assert (REJECTED, BY_PATTERN, BY_LIST, NOT_EXCLUDED, ALWAYS) == (0, 1, 2, 3, 255)


# the manual's example


@pytest.mark.conforms("X3-26")
@pytest.mark.parametrize("stage", ["pattern", "list"])
def test_the_manual_s_100_to_103(stage: str) -> None:
    """5.2.4: code 001 0000 0000 0, mask 111 1111 1100 1."""
    filter = both(INCL)
    code, mask = 0b001_0000_0000_0, 0b111_1111_1100_1
    if stage == "pattern":
        filter.standard.set_pattern(code, mask)
    else:
        filter.standard.set_pattern(CODE_NONE, MASK_NONE)
        filter.standard.add(code, mask)
    expected = [0x100 << 1, 0x101 << 1, 0x102 << 1, 0x103 << 1]
    assert passing(filter) == dict.fromkeys(expected, BY_PATTERN if stage == "pattern" else BY_LIST)


@pytest.mark.conforms("X3-26")
def test_the_two_formats_have_nothing_to_do_with_each_other() -> None:
    filter = both(INCL)
    filter.standard.set_pattern(0x100 << 1, 0xFFF)
    filter.extended.set_pattern(CODE_NONE, MASK_NONE)
    filter.extended.add(0x123 << 1, 0x3FFFFFFF)
    assert passing(filter) == {0x200: BY_PATTERN}
    assert passing(filter, extended=True) == {0x246: BY_LIST}
    assert filter.of(False) is filter.standard
    assert filter.of(True) is filter.extended


@pytest.mark.conforms("X3-26")
def test_twenty_nine_bits_and_the_remote_bit_are_compared() -> None:
    filter = both(INCL)
    filter.extended.set_pattern(0x1FFFFFFF << 1, 0x3FFFFFFF)
    assert filter.judge(head(0x1FFFFFFF, extended=True)) == BY_PATTERN
    assert filter.judge(head(0x1FFFFFFF, extended=True, remote=True)) == REJECTED
    assert filter.judge(head(0x0FFFFFFF, extended=True)) == REJECTED
    assert filter.judge(head(0x1FFFFFFE, extended=True)) == REJECTED


@each("more", [0xF << 16, 1 << 10 | 1 << 11, 1 << 21, 1 << 8, 1 << 9, 0xFF << 24])
def test_nothing_but_the_identifier_and_the_remote_bit_counts(more: int) -> None:
    filter = both(INCL)
    filter.standard.set_pattern(0x123 << 1, 0xFFF)
    assert filter.judge(head(0x123, more=more)) == BY_PATTERN
    assert filter.judge(head(0x122, more=more)) == REJECTED


# opening and closing the first stage


@pytest.mark.conforms("X3-28")
@pytest.mark.parametrize("extended", [False, True])
def test_code_none_shuts_the_pattern_and_leaves_the_list(extended: bool) -> None:
    filter = both(INCL)
    filter.of(extended).add(0x40, 0x3FFFFFFF)
    filter.of(extended).set_pattern(CODE_NONE, MASK_NONE)
    assert passing(filter, extended=extended) == {0x40: BY_LIST}


@pytest.mark.conforms("X3-28")
def test_code_all_opens_it_and_makes_the_list_moot() -> None:
    filter = both(INCL)
    filter.standard.set_pattern(CODE_NONE, MASK_NONE)
    filter.standard.add(0x40, 0xFFF)
    filter.standard.set_pattern(CODE_ALL, MASK_ALL)
    assert passing(filter) == dict.fromkeys(range(4096), BY_PATTERN)


@pytest.mark.conforms("X4-34")
def test_an_excluding_filter_is_open_until_something_is_registered() -> None:
    filter = both(EXCL)
    filter.standard.add(0x40, 0xFFF)
    assert passing(filter) == dict.fromkeys(set(range(4096)) - {0x40}, NOT_EXCLUDED)
    filter.standard.set_pattern(0x800, 0x800)
    assert passing(filter) == dict.fromkeys(set(range(0x800)) - {0x40}, NOT_EXCLUDED)


def test_changing_the_mode_keeps_pattern_and_list() -> None:
    filter = both(INCL)
    filter.standard.set_pattern(CODE_NONE, MASK_NONE)
    filter.standard.add(0x40, 0xFFF)
    codes = {PASS: (ALWAYS, ALWAYS), EXCL: (REJECTED, NOT_EXCLUDED), LOCK: (0, 0), INCL: (BY_LIST, REJECTED)}
    for mode, expected in codes.items():
        filter.standard.mode = mode
        assert (filter.judge(head(0x20)), filter.judge(head(0x21))) == expected


@each("bit", [12, 20, 29, 30])
def test_bits_above_the_identifier_do_not_count(bit: int) -> None:
    filter = both(INCL)
    filter.standard.set_pattern(0x40 | 1 << bit, 0xFFF | 1 << bit)
    assert passing(filter) == {0x40: BY_PATTERN}


# the list


@pytest.mark.conforms("X3-27")
def test_the_list_of_11_bits_holds_every_identifier_twice() -> None:
    """2048 identifiers, each as data and as remote frame (source: rulings.md 5)."""
    filter = both(INCL)
    filter.standard.set_pattern(CODE_NONE, MASK_NONE)
    filter.standard.add(0, 0)
    assert passing(filter) == dict.fromkeys(range(4096), BY_LIST)
    filter.standard.add(0x40, 0xFFF)  # it is there already
    filter.standard.remove(1, 1)
    assert passing(filter) == dict.fromkeys(range(0, 4096, 2), BY_LIST)
    filter.standard.remove(0, 0)
    assert passing(filter) == {}


@pytest.mark.conforms("X3-27")
def test_the_list_of_29_bits_holds_2048_identifiers_twice() -> None:
    filter = both(INCL)
    filter.extended.set_pattern(CODE_NONE, MASK_NONE)
    filter.extended.add(0x100000, 0x3FFFF001)  # 2048 identifiers, as data frames
    filter.extended.add(0x100001, 0x3FFFF001)  # and as remote frames
    assert len(filter.extended.listed) == 4096
    with pytest.raises(BadFilter, match="4097 entries: the list holds 4096"):
        filter.extended.add(0, 0x3FFFFFFF)
    filter.extended.add(0x100000, 0x3FFFFFFF)
    assert filter.judge(head(0, extended=True)) == REJECTED
    assert filter.judge(head(0x807FF, extended=True)) == BY_LIST
    filter.extended.remove(0x100001, 0x3FFFFFFF)
    filter.extended.add(0, 0x3FFFFFFF)
    assert filter.judge(head(0, extended=True)) == BY_LIST


@pytest.mark.conforms("X3-27")
@each("mask", [0, 1, 0x3FFF0000, 0x3FFFE000])
def test_more_than_fits_changes_nothing(mask: int) -> None:
    """Neither does it count to 2**30 before it says so."""
    filter = both(INCL)
    filter.extended.add(0x40, 0x3FFFFFFF)
    with pytest.raises(BadFilter, match="the list holds 4096"):
        filter.extended.add(0, mask)
    assert filter.extended.listed == {0x40}


@pytest.mark.parametrize("extended", [False, True])
def test_a_shut_pattern_registers_nothing(extended: bool) -> None:
    filter = both(INCL)
    filter.of(extended).add(CODE_NONE, MASK_NONE)
    filter.of(extended).add(CODE_NONE, 0x80000000)
    assert filter.of(extended).listed == set()


@pytest.mark.parametrize("extended", [False, True])
def test_without_a_list_nothing_can_be_registered(extended: bool) -> None:
    filter = both(INCL, 0)
    with pytest.raises(NotInitialised, match="without a list"):
        filter.of(extended).add(0x40, 0x3FFFFFFF)
    filter.of(extended).remove(0x40, 0x3FFFFFFF)
    filter.of(extended).set_pattern(0x40, 0x3FFFFFFF)  # the first stage is there all the same
    assert passing(filter, extended=extended) == {0x40: BY_PATTERN}


# mistakes


@each(
    ("code", "mask", "name"), [(-1, 0, "code"), (0, -1, "mask"), (1 << 32, 0, "code"), (0, 1 << 32, "mask")]
)
def test_numbers_that_are_no_32_bits(code: int, mask: int, name: str) -> None:
    filter = both(INCL)
    for change in (filter.standard.set_pattern, filter.standard.add, filter.extended.remove):
        with pytest.raises(BadFilter, match=f"{name} .*32 bits"):
            change(code, mask)
    assert passing(filter) == dict.fromkeys(range(4096), BY_PATTERN)
    assert filter.standard.listed == set()


@each("mode", [FilterMode.VOID, 5, -1, 0x80])
def test_no_such_mode(mode: int) -> None:
    for modes in ((mode, PASS), (PASS, mode)):
        with pytest.raises(BadFilter, match="filter mode"):
            message_filter(modes[0], 2048, modes[1], 2048)


@each("size", [-1, LARGEST_LIST + 1, 1 << 40])
def test_no_such_list(size: int) -> None:
    for sizes in ((size, 0), (0, size)):
        with pytest.raises(BadFilter, match="list of"):
            message_filter(PASS, sizes[0], PASS, sizes[1])


# against a model


@dataclass
class Model:
    """The manual's words, one frame at a time: a pattern, and every call that changed the list, in order."""

    mode: int
    width: int
    pattern: tuple[int, int] | None
    changes: list[tuple[bool, int, int]] = field(default_factory=list)

    def agrees(self, value: int, code: int, mask: int) -> bool:
        for bit in range(self.width):
            if mask >> bit & 1 and (value >> bit & 1) != (code >> bit & 1):
                return False
        return not (mask >> 31 & 1 and code >> 31 & 1)  # no frame has bit 31

    def registered(self, value: int) -> bool:
        found = False
        for add, code, mask in self.changes:
            if self.agrees(value, code, mask):
                found = add
        return found

    def judge(self, value: int) -> int:
        by_pattern = self.pattern is not None and self.agrees(value, *self.pattern)
        by_list = self.registered(value)
        if self.mode == INCL:
            return BY_PATTERN if by_pattern else BY_LIST if by_list else REJECTED
        if self.mode == EXCL:
            return REJECTED if by_pattern or by_list else NOT_EXCLUDED
        return {LOCK: REJECTED, PASS: ALWAYS}[self.mode]


def values(width: int) -> st.SearchStrategy[int]:
    few = st.sampled_from([0, 1, 2, 3, 0x246, 0x247, (1 << width) - 1, 1 << (width - 1)])
    return few | st.integers(0, (1 << width) - 1)


@st.composite
def patterns(draw: st.DrawFn, width: int, most_free: int) -> tuple[int, int]:
    """Code and mask; the mask leaves a few bits open, and now and then bit 31 is in it."""
    free = draw(st.sets(st.integers(0, width - 1), max_size=most_free))
    mask = (1 << width) - 1 & ~sum(1 << bit for bit in free)
    code = draw(values(width))
    shut = draw(st.integers(0, 9))
    return code | (1 << 31 if shut == 0 else 0), mask | (1 << 31 if shut <= 1 else 0)


@pytest.mark.conforms("X3-26", "X3-27", "X4-33", "X4-34")
@pytest.mark.parametrize("extended", [False, True])
@examples(100)
@given(data=st.data())
def test_any_filter_does_what_the_manual_says(extended: bool, data: st.DataObject) -> None:
    width = WIDTH[extended]
    mode = data.draw(st.sampled_from(MODES))
    filter = both(mode)
    tried: FormatFilter = filter.of(extended)
    model = Model(mode, width, None if mode == EXCL else (0, 0))
    steps = st.sampled_from(["pattern", "add", "add", "remove", "mode"])
    seen = {0, 1, (1 << width) - 1}
    for step in data.draw(st.lists(steps, max_size=8)):
        if step == "mode":
            model.mode = tried.mode = data.draw(st.sampled_from(MODES))
            continue
        code, mask = data.draw(patterns(width, width if step == "pattern" else 8))
        seen |= {
            code & (1 << width) - 1,
            (code ^ 1) & (1 << width) - 1,
            (code ^ 1 << width - 1) & (1 << width) - 1,
        }
        if step == "pattern":
            tried.set_pattern(code, mask)
            model.pattern = code, mask
        else:
            (tried.add if step == "add" else tried.remove)(code, mask)
            model.changes.append((step == "add", code, mask))
    seen |= set(data.draw(st.lists(values(width), max_size=20)))
    for value in seen:
        word = head(value >> 1, remote=bool(value & 1), extended=extended)
        assert filter.judge(word) == model.judge(value), hex(value)
    other = {
        value: filter.judge(head(value >> 1, remote=bool(value & 1), extended=not extended))
        for value in (0, 5)
    }
    untouched = Model(mode, WIDTH[not extended], None if mode == EXCL else (0, 0))
    assert other == {value: untouched.judge(value) for value in (0, 5)}


@pytest.mark.conforms("X3-27")
@examples(50)
@given(st.integers(1, 12), st.lists(st.tuples(st.booleans(), patterns(12, 4)), max_size=8))
def test_the_list_is_full_when_it_is_full(size: int, changes: list[tuple[bool, tuple[int, int]]]) -> None:
    filter = message_filter(INCL, size, INCL, size)
    held: set[int] = set()
    model = Model(INCL, 12, None)
    for add, (code, mask) in changes:
        matching = {value for value in range(4096) if model.agrees(value, code, mask)}
        if not add:
            filter.standard.remove(code, mask)
            held -= matching
        elif len(held | matching) > 2 * size:
            with pytest.raises(BadFilter, match=f"the list holds {2 * size}"):
                filter.standard.add(code, mask)
        else:
            filter.standard.add(code, mask)
            held |= matching
        assert filter.standard.listed == held
    filter.standard.set_pattern(CODE_NONE, MASK_NONE)
    assert passing(filter) == dict.fromkeys(held, BY_LIST)
