"""docs/tools.md: its blocks run, and its table of formats has those there are."""

from __future__ import annotations

import re
from pathlib import Path

from canwire import log_formats
from tests.docs.blocks import ROOT, run_console, run_python

PAGE = ROOT / "docs" / "tools.md"


def test_its_commands_run(tmp_path: Path) -> None:
    said = run_console(PAGE, tmp_path)
    assert "12974 entries from candump to blf" in said
    assert "frames delivered" in said


def test_its_programs_print_what_stands_there() -> None:
    assert run_python(PAGE) >= 1


def test_its_table_has_every_format() -> None:
    rows = dict(re.findall(r"^\| `(\w+)`[^|]*\| (\.\w+)", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    assert rows == {row.name: row.suffixes[0] for row in log_formats() if row.name != "journal"}
