"""A loop over cases says which of them fail, whatever they fail with."""

from __future__ import annotations

import inspect

import pytest

from tests.cases import each, hold_for_each


def named(error: pytest.ExceptionInfo[ExceptionGroup]) -> str:
    return error.value.message


def test_all_that_fail_are_named() -> None:
    """Also what misses a raise, fails by itself or skips: pytest's own ends are no Exception."""

    def rule(case: str) -> None:
        if case == "asserts":
            raise AssertionError
        if case == "raises":
            raise ValueError
        if case == "misses":
            with pytest.raises(KeyError):
                pass
        if case == "skips":
            pytest.skip("not here")

    with pytest.raises(ExceptionGroup) as error:
        hold_for_each(["good", "asserts", "misses", "also good", "raises", "skips"], rule)
    assert named(error) == "4 of 6 cases fail: asserts; misses; raises; skips"
    with pytest.raises(AssertionError, match="no cases"):
        hold_for_each([], rule)


def test_each_is_every_combination_and_leaves_fixtures_and_marks() -> None:
    tried = []

    @each("size", [1, 2])
    @pytest.mark.conforms("N-17")
    @each(("low", "high"), [(0, 5), pytest.param(6, 9, id="upper half")])
    def test(fixture: str, low: int, high: int, size: int) -> None:
        tried.append((fixture, low, high, size))
        assert (low, size) != (0, 2) and (low, size) != (6, 1)  # noqa: PT018

    assert list(inspect.signature(test).parameters) == ["fixture"]
    assert [mark.args for mark in test.pytestmark] == [("N-17",)]
    with pytest.raises(ExceptionGroup) as error:
        test(fixture="made")
    assert tried == [("made", low, high, size) for size in (1, 2) for low, high in ((0, 5), (6, 9))]
    assert named(error) == "2 of 4 cases fail: size=1, upper half; size=2, low=0, high=5"


@pytest.mark.parametrize(
    ("ids", "name"), [(None, "n=7"), (["seven"], "seven"), (lambda value: f"<{value}>", "<7>")]
)
def test_a_case_has_the_name_that_it_was_given(ids: object, name: str) -> None:
    @each("n", iter([7]), ids=ids)  # type: ignore[arg-type]
    def test(n: int) -> None:
        assert n != 7

    with pytest.raises(ExceptionGroup) as error:
        test()
    assert named(error) == f"1 of 1 cases fail: {name}"


def test_what_would_check_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="n: there are no cases"):
        each("n", [])
    with pytest.raises(ValueError, match="has no marks"):
        each("n", [pytest.param(1, marks=pytest.mark.skip)])
    with pytest.raises(ValueError, match=r"longer|shorter"):
        each("n, m", [(1, 2, 3)])
