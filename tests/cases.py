"""One test for many cases of one rule: each is tried, and all that fail are named together."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

Case = TypeVar("Case")


def hold_for_each(cases: Iterable[Case], rule: Callable[[Case], object]) -> None:
    """Call `rule` with each case; raises an ExceptionGroup of what it raised, each noted with its case's name."""
    failures: list[Exception] = []
    tried = 0
    for case in cases:
        tried += 1
        try:
            rule(case)
        except Exception as error:
            error.add_note(f"case: {case}")
            failures.append(error)
    assert tried, "there are no cases"
    if failures:
        names = "; ".join(failure.__notes__[-1].removeprefix("case: ") for failure in failures)
        raise ExceptionGroup(f"{len(failures)} of {tried} cases fail: {names}", failures)
