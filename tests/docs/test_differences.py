"""What the manuals' pages say of differences is true: each row has its tests, which `differences.PAGES` names.

A row without a proof, a proof without its row and a proof that is no test fail.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from tests.cases import each, hold_for_each
from tests.docs.differences import PAGES, Page

TESTS = Path(__file__).resolve().parents[1]
DOCS = TESTS.parent / "docs"


def rows(page: Page) -> list[str]:
    """First cells of the section's tables, without their headers'."""
    text = (DOCS / page.file).read_text(encoding="utf-8")
    [section] = re.findall(rf"^## {page.section}\n(.*?)(?=^## )", text, re.MULTILINE | re.DOTALL)
    assert "tests/docs/differences.py" in section, "the section says where its proofs are"
    tables = re.findall(r"^\|.*\n\|---.*\n((?:\|.*\n)+)", section, re.MULTILINE)
    return [line.split(" | ")[0].removeprefix("| ") for table in tables for line in table.splitlines()]


def proofs(text: str) -> Iterator[tuple[str, str]]:
    file = ""
    for word in text.split():
        before, _, name = word.rpartition("::")
        file = before or file
        yield file, f"test_{name}"


@cache
def names_in(file: str) -> set[str]:
    tree = ast.parse((TESTS / f"{file}.py").read_text(encoding="utf-8"))
    return {one.name for one in tree.body if isinstance(one, ast.FunctionDef)}


@each("manual", PAGES)
def test_each_row_has_its_proof_and_each_proof_its_row(manual: str) -> None:
    assert sorted(rows(PAGES[manual])) == sorted(PAGES[manual].proofs)


@each("manual", PAGES)
def test_each_proof_is_a_test(manual: str) -> None:
    def check(row: str) -> None:
        found = list(proofs(PAGES[manual].proofs[row]))
        assert found
        for file, name in found:
            assert name in names_in(file), f"{file}: {name}"

    hold_for_each(PAGES[manual].proofs, check)
