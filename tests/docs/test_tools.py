"""docs/tools.md: its commands succeed and show what they say, and its picture is what the window shows now."""

from __future__ import annotations

import re
from html import unescape
from pathlib import Path

import pytest

from tests.docs.blocks import ROOT, run_console

PAGE = ROOT / "docs" / "tools.md"


def test_commands(tmp_path: Path) -> None:
    pytest.importorskip("textual")
    shown = run_console(PAGE, tmp_path)
    assert re.search(r"^  can0  10[01]   \[8\]  [0-9A-F]{2} ", shown, re.MULTILINE)
    assert re.search(r"^ \(\d{6}\.\d{9}\)  HW000002:1  10[0-3]   \[8\]", shown, re.MULTILINE)
    assert '"line": "can0"' in shown
    assert re.search(r"^can0 +100 +8 +\d+ ", shown, re.MULTILINE)
    assert re.search(r"^can0 +\d+\.\d %  peak", shown, re.MULTILINE)
    assert "HW000003:0 on can0: 500000 bit/s" in shown


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
