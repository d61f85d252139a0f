"""Source, tests and pages cite the manuals by their names, which docs/reference/index.md lists."""

from __future__ import annotations

import re
from pathlib import Path

from tests.docs.blocks import ROOT

NUMBERED = re.compile(r"\bseeds? 00\d\b", re.IGNORECASE)
FOLDERS = ("src", "tests", "docs", "examples", "benchmarks")
HISTORY = (Path("docs/reference/findings"), Path("docs/roadmap.md"))
TEXTS = {".py", ".pxd", ".md", ".toml", ".c", ".h", ".cpp", ".cs", ".js", ".jinja", ".rst"}


def texts() -> list[Path]:
    found = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.suffix in TEXTS]
    return [path for path in found if not any(path.is_relative_to(ROOT / old) for old in HISTORY)]


def test_no_manual_is_cited_by_a_number() -> None:
    citing = [path for path in texts() if NUMBERED.search(path.read_text(encoding="utf-8"))]
    assert citing == []


def test_the_table_of_sources_has_every_manual() -> None:
    table = (ROOT / "docs" / "reference" / "index.md").read_text(encoding="utf-8")
    for name in (
        "CANDRV manual",
        "INduCAN104 manual",
        "VCI V3 .NET manual",
        "CANBUS manual",
        "VCI V4 manual",
    ):
        assert f"| {name} |" in table
