"""What every page for people who come from another interface begins and ends with."""

from __future__ import annotations

import re
from pathlib import Path

from tests.cases import each

DOCS = Path(__file__).resolve().parents[2] / "docs"
DIFFERENCES = {
    "porting-vci.md": "Differences from real boards",
    "porting-candrv.md": "Differences from real boards",
    "porting-acan.md": "Differences from real boards",
    "python-can.md": "Differences from other interfaces",
    "slcan.md": "Differences from a real dongle",
}
LONGEST_FIRST = 17  # lines: VCI needs two channels and two control units; the others have ten or fewer


@each("page", DIFFERENCES)
def test_it_begins_with_a_short_program(page: str) -> None:
    """Before anything else, with what it prints; that it does is tested with the page's other samples."""
    text = (DOCS / page).read_text(encoding="utf-8")
    before, program, after = re.split(
        r"^```python\n(.*?)^```$", text, maxsplit=1, flags=re.MULTILINE | re.DOTALL
    )
    assert [
        title for title in re.findall(r"^## (.*)$", before, re.MULTILINE) if title != "A first program"
    ] == []
    assert len([line for line in program.splitlines() if line.strip()]) <= LONGEST_FIRST
    assert "print(" in program
    assert re.search(r"^```text$|prints\n?`", after.partition("\n## ")[0], re.MULTILINE)


@each("page", DIFFERENCES)
def test_it_has_a_table_of_differences(page: str) -> None:
    header, *rows = _table(page, DIFFERENCES[page])
    assert len(rows) >= 15
    assert {len(row) for row in rows} == {len(header)}


@each("page", DIFFERENCES)
def test_it_has_a_table_of_troubles(page: str) -> None:
    header, *rows = _table(page, "Troubles?")
    assert header == ["what you see", "why", "what to do"]
    assert len(rows) >= 9
    assert all(len(row) == 3 and all(row) for row in rows)


def _table(page: str, heading: str) -> list[list[str]]:
    """The cells of the section's first table, its header first."""
    text = (DOCS / page).read_text(encoding="utf-8")
    [section] = re.findall(rf"^## {heading}\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    table = re.search(r"^\|.*?(?=^\s*$|\Z)", section, re.MULTILINE | re.DOTALL)
    assert table is not None
    rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in table[0].splitlines()]
    return [rows[0], *rows[2:]]
