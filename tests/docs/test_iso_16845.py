"""docs/iso-16845.md is what the suite says, and the suite knows every purpose."""

from __future__ import annotations

from docs import iso_16845
from tests.iso16845.purposes import BY_NUMBER, IDEAL_ONLY, KINDS, OPEN, PURPOSES, why_not


def test_the_page_is_what_the_script_writes() -> None:
    assert iso_16845.page() == iso_16845.PAGE.read_text(encoding="utf-8"), "run: python docs/iso_16845.py"


def test_every_purpose_is_there_once() -> None:
    assert len(PURPOSES) == len(BY_NUMBER) == 194
    assert set(IDEAL_ONLY) <= set(BY_NUMBER)
    assert {number for number, _ in OPEN} <= set(BY_NUMBER)


def test_every_purpose_that_applies_has_a_test() -> None:
    wanted = {number for number in BY_NUMBER if any(not why_not(number, kind) for kind in KINDS)}
    assert wanted == set(iso_16845.shown())
