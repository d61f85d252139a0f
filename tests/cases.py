"""One test for many cases of one rule: each is tried, and all that fail are named together.

`each` is written as `pytest.mark.parametrize` is. It costs nothing for a case but the case itself, where a test of its
own costs 1.5 ms, and 0.2 ms more for each worker that collects it. It suits rules whose fixtures stay as they are; a
case that needs fresh fixtures, or may be skipped, is a test of its own.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, TypeVar

import pytest

Case = TypeVar("Case")
Test = Callable[..., None]
_ENDED = (
    pytest.fail.Exception,
    pytest.skip.Exception,
)  # which are no Exception: also what a missing raise ends with
_LONGEST_NAME = 200


def hold_for_each(cases: Iterable[Case], rule: Callable[[Case], object]) -> None:
    """Call `rule` with each case; raises an ExceptionGroup of what it raised, each noted with its case's name."""
    failures: list[Exception] = []
    tried = 0
    for case in cases:
        tried += 1
        try:
            _try(rule, case)
        except Exception as error:
            error.add_note(f"case: {case}")
            failures.append(error)
    assert tried, "there are no cases"
    if failures:
        names = "; ".join(failure.__notes__[-1].removeprefix("case: ") for failure in failures)
        raise ExceptionGroup(f"{len(failures)} of {tried} cases fail: {names}", failures)


def _try(rule: Callable[[Case], object], case: Case) -> None:
    try:
        rule(case)
    except _ENDED as ended:
        raise AssertionError(f"{type(ended).__name__}: {ended}") from ended


class Row(NamedTuple):
    """What a test is called with, by the names of its parameters; and a case's name, if it has one of its own."""

    values: dict[str, object]
    own_name: str = ""

    def __str__(self) -> str:
        if self.own_name:
            return self.own_name
        return ", ".join(f"{name}={value!r}"[:_LONGEST_NAME] for name, value in self.values.items())


Ids = Callable[[Any], object] | Iterable[object] | None


def each(names: str | Sequence[str], cases: Iterable[Any], *, ids: Ids = None) -> Callable[[Test], Test]:
    """The test with each of these cases, in a loop; more than one `each` gives every combination.

    `names`, `cases` and `ids` are those of `pytest.mark.parametrize`. Raises ValueError for a `pytest.param` with
    marks, or without cases, and when a test is called an ExceptionGroup that names all cases that fail.
    """
    words = [word.strip() for word in names.split(",")] if isinstance(names, str) else list(names)
    rows = list(_rows(words, isinstance(names, str) and "," not in names, list(cases), ids))
    if not rows:
        raise ValueError(f"{names}: there are no cases")

    def decorate(test: Test) -> Test:
        return _looped(test, words, rows)

    return decorate


def _rows(words: list[str], single: bool, cases: list[Any], ids: Ids) -> Iterable[Row]:
    own_names = [None] * len(cases) if ids is None or callable(ids) else list(ids)
    for case, own_name in zip(cases, own_names, strict=True):
        if isinstance(case, type(pytest.param())):
            if case.marks:
                raise ValueError(f"{case}: a case of a loop has no marks")
            values, own_name = case.values, case.id
        else:
            values = (case,) if single else tuple(case)
        row = Row(dict(zip(words, values, strict=True)), str(own_name or ""))
        if callable(ids) and not row.own_name:
            row = row._replace(own_name="-".join(str(ids(value) or value) for value in values))
        yield row


def _looped(test: Test, words: list[str], rows: list[Row]) -> Test:
    table: list[Row] = getattr(test, "_cases", [Row({})])
    rule: Test = getattr(test, "_rule", test)
    both = [
        Row(row.values | more.values, ", ".join(filter(None, (str(row), str(more))))) if more.values else row
        for row in rows
        for more in table
    ]

    @functools.wraps(test)
    def looped(*itself: object, **fixtures: Any) -> None:
        def play(row: Row) -> None:
            if "capsys" in fixtures:
                fixtures["capsys"].readouterr()  # what the case before has printed
            rule(*itself, **fixtures, **row.values)

        hold_for_each(both, play)

    taken = inspect.signature(test)
    left = [taken.parameters[name] for name in taken.parameters if name not in words]
    looped.__signature__ = taken.replace(parameters=left)  # type: ignore[attr-defined]
    looped._cases, looped._rule = both, rule  # type: ignore[attr-defined]
    return looped
