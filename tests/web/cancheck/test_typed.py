"""A generator's window as it is typed: what it means under each Align, and that Edit shows it again."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.candrv.filters import aligned, identifier_width
from canwire.web.cancheck.recipe import Range, Recipe
from canwire.web.cancheck.typed import shown_recipe, typed_recipe
from canwire.web.fields import BadFields, Fields
from canwire.web.words import words_in

pytestmark = pytest.mark.conforms("FT-14")

WORD = words_in("en")
PLAIN = {"id": "123", "dlc": "2", "b0": "AA", "b1": "5", "delay": "250"}


def typed(values: dict[str, str], *, align: int = 0, extended: bool = True) -> Recipe:
    return typed_recipe(Fields(values, WORD), WORD, align=align, extended=extended)


def faults(values: dict[str, str], **how: bool) -> set[str]:
    with pytest.raises(BadFields) as caught:
        typed(values, **how)
    return set(caught.value.faults)


def test_all_numbers_but_the_delay_are_hexadecimal() -> None:
    assert typed(PLAIN) == Recipe(Range(0x123, 0x123), (Range(0xAA, 0xAA), Range(0x05, 0x05)), delay_ms=250)


def test_without_use_range_the_second_line_does_not_count() -> None:
    assert typed({**PLAIN, "idto": "zz", "t0": "zz", "wrap": "on", "repeat": "on"}) == typed(PLAIN)


@pytest.mark.parametrize(
    ("wrong", "at"),
    [
        ({"id": "800"}, {"id"}),
        ({"id": "20000000", "ext": "on"}, {"id"}),
        ({"id": ""}, {"id"}),
        ({"dlc": "9"}, {"dlc"}),
        ({"dlc": "F"}, {"dlc"}),
        ({"dlc": "3"}, {"b2"}),
        ({"b0": "100"}, {"b0"}),
        ({"b0": "1G", "b1": ""}, {"b0", "b1"}),
        ({"delay": "-1"}, {"delay"}),
        ({"delay": "A"}, {"delay"}),
        ({"delay": "4294967296"}, {"delay"}),
        ({"range": "on"}, {"idto", "t0", "t1"}),
        ({"range": "on", "idto": "FFF", "t0": "0", "t1": "0"}, {"idto"}),
    ],
)
def test_each_fault_is_told_at_its_field(wrong: dict[str, str], at: set[str]) -> None:
    assert faults({**PLAIN, **wrong}) == at


def test_extended_frames_take_can_2_0b() -> None:
    assert faults({**PLAIN, "ext": "on"}, extended=False) == {"ext"}


@pytest.mark.parametrize(
    ("align", "word", "last"), [(0, "123", "125"), (2, "48C0000", "4940000"), (3, "24600000", "24A00000")]
)
def test_identifiers_lie_as_align_says_and_step_by_one_identifier(align: int, word: str, last: str) -> None:
    values = {"id": word, "idto": last, "dlc": "0", "delay": "1", "range": "on"}
    recipe = typed(values, align=align)
    assert [recipe.message(step).identifier for step in range(3)] == [0x123, 0x124, 0x125]


def test_bits_beside_the_identifier_are_refused() -> None:
    with pytest.raises(BadFields):
        typed({**PLAIN, "id": "123"}, align=3)


values = st.integers(0, 255)
recipes = st.builds(
    lambda extended, align, first, last, data, **more: (
        align,
        Recipe(
            Range(first & identifier_width(extended, align), last & identifier_width(extended, align)),
            tuple(Range(*pair) for pair in data),
            extended=extended,
            use_range=True,
            **more,
        ),
    ),
    st.booleans(),
    st.integers(0, 3),
    st.integers(0, 0x1FFFFFFF),
    st.integers(0, 0x1FFFFFFF),
    st.lists(st.tuples(values, values), max_size=8),
    rtr=st.booleans(),
    delay_ms=st.integers(0, 0xFFFFFFFF),
    wrap=st.booleans(),
    repeat=st.booleans(),
)


@given(recipes)
def test_edit_shows_what_was_typed(aligned_recipe: tuple[int, Recipe]) -> None:
    align, recipe = aligned_recipe
    shown = shown_recipe(recipe, align)
    fields = {
        name: "on" if value is True else value
        for name, value in shown.items()
        if isinstance(value, str) or value
    }
    assert typed({name: str(value) for name, value in fields.items()}, align=align) == recipe
    assert int(str(shown["id"]), 16) == aligned(recipe.identifier.first, recipe.extended, align)
