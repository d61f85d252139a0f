"""`canwire serve --programs`: how many programs, or which."""

from __future__ import annotations

import argparse

import pytest

from canwire.commands.serve import _programs
from tests.cases import each


@each(("text", "programs"), [("3", 3), ("1", 1), ("a", ["a"]), ("a, b", ["a", "b"])])
def test_a_number_or_names(text: str, programs: int | list[str]) -> None:
    assert _programs(text) == programs


@each("text", ["0", "-1", "", "a,", "a,a", "2,a"])
def test_mistakes(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="a number from 1 up"):
        _programs(text)
