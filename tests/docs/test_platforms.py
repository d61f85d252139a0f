"""The page of systems: its commands succeed, and the files that it names are there."""

from __future__ import annotations

import re
from pathlib import Path

from tests.docs.blocks import ROOT, run_console

PAGE = ROOT / "docs" / "platforms.md"


def test_commands(tmp_path: Path) -> None:
    assert "HW000002" in run_console(PAGE, tmp_path)


def test_the_untested_places_exist() -> None:
    named = re.findall(r"`((?:platform|hub|commands)/[\w/]+\.py)`", PAGE.read_text(encoding="utf-8"))
    assert len(named) > 8
    assert [name for name in named if not (ROOT / "src" / "canwire" / name).exists()] == []
