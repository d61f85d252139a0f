"""The one pattern that says which frames a line's filter may let pass, for controllers with a filter of their own."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from canwire.boards.can.bounds import bounds
from canwire.boards.can.message_filter import FormatFilter
from canwire.boards.can.modes import FilterMode
from tests.cases import each

WIDTH = 12  # of an 11-bit identifier and the remote bit behind it
FULL = (1 << WIDTH) - 1
SHUT = 1 << 31


def inclusive(code: int, mask: int, *listed: int) -> FormatFilter:
    """It lets the pattern pass, and these values."""
    made = FormatFilter(FilterMode.INCLUSIVE, 16, WIDTH)
    made.set_pattern(code, mask)
    for value in listed:
        made.add(value, FULL)
    return made


@each(
    ("found", "pattern"),
    [
        (FormatFilter(FilterMode.LOCK, 16, WIDTH), None),
        (FormatFilter(FilterMode.PASS, 16, WIDTH), (0, 0)),
        (FormatFilter(FilterMode.EXCLUSIVE, 16, WIDTH), (0, 0)),
        (inclusive(0x246, FULL), (0x246, FULL)),
        (inclusive(0x246, 0xFF0), (0x240, 0xFF0)),
        (inclusive(SHUT, SHUT), None),
        (inclusive(SHUT, SHUT, 0x200), (0x200, FULL)),
        (inclusive(SHUT, SHUT, 0x200, 0x201), (0x200, FULL - 1)),
        (inclusive(0x200, FULL, 0x210), (0x200, FULL - 0x10)),
        (inclusive(0x200, 0xF00, 0x2F0), (0x200, 0xF00)),
    ],
)
def test_patterns(found: FormatFilter, pattern: tuple[int, int] | None) -> None:
    assert bounds(found) == pattern


@given(
    st.integers(0, FULL),
    st.integers(0, FULL),
    st.lists(st.integers(0, FULL), max_size=4),
    st.integers(0, FULL),
)
def test_what_the_filter_lets_pass_agrees_with_the_pattern(
    code: int, mask: int, listed: list[int], value: int
) -> None:
    found = inclusive(code, mask, *listed)
    pattern = bounds(found)
    assert pattern is not None
    for passing in (value, *listed, code):
        if found.judge(passing):
            assert (passing ^ pattern[0]) & pattern[1] == 0
