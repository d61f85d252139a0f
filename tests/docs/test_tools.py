"""docs/tools.md: its blocks run, its table of formats has those there are, its picture is what the window shows now."""

from __future__ import annotations

import re
from html import unescape
from pathlib import Path

import pytest

from canwire import log_formats
from tests.docs.blocks import ROOT, run_console, run_python

PAGE = ROOT / "docs" / "tools.md"


@pytest.mark.long
def test_its_commands_run(tmp_path: Path) -> None:
    pytest.importorskip("textual")
    pytest.importorskip("duckdb")
    pytest.importorskip("matplotlib")
    shown = run_console(PAGE, tmp_path)
    assert "12974 entries from candump to blf" in shown
    assert "258  936\n278  934\n" in shown
    assert "frames delivered" in shown
    assert re.search(r"^vcan0: 12974 frames.* load 35\.8 %", shown, re.MULTILINE)
    assert re.search(r"samples of 1 signals in .*now\.html", shown)
    assert re.search(r"samples of \d signals in .*engine\.svg", shown)
    assert re.search(r"^  can0  10[01]   \[8\]  [0-9A-F]{2} ", shown, re.MULTILINE)
    assert re.search(r"^ \(\d{6}\.\d{9}\)  HW000002:1  10[0-3]   \[8\]", shown, re.MULTILINE)
    assert '"line": "can0"' in shown
    assert re.search(r"^can0 +100 +8 +\d+ ", shown, re.MULTILINE)
    assert re.search(r"^can0 +\d+\.\d %  peak", shown, re.MULTILINE)
    assert "HW000003:0 on can0: 500000 bit/s" in shown


def test_its_programs_print_what_stands_there() -> None:
    pytest.importorskip("duckdb")
    assert run_python(PAGE) >= 1


def test_its_table_has_every_format() -> None:
    rows = dict(re.findall(r"^\| `([\w-]+)`[^|]*\| (\.\w+)", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    assert rows == {row.name: row.suffixes[0] for row in log_formats() if row.name != "journal"}


def words(picture: str) -> list[str]:
    """What stands in it, without how Textual draws that."""
    return [unescape(text).strip() for text in re.findall(r">([^<>\n]+)</text>", picture)]


def test_the_picture_is_up_to_date() -> None:
    pytest.importorskip("textual")
    pytest.importorskip("cantools")
    import view_picture

    kept = words(view_picture.PAGE.read_text(encoding="utf-8"))
    assert kept == words(view_picture.picture())
    assert any("Chosen(Which" in text.replace("\xa0", " ") for text in kept)
