"""docs/conformance.md says what the markers say, and the markers name behaviours that exist."""

from pathlib import Path

from docs import conformance

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "conformance.md"


def test_the_page_is_what_the_markers_say() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert conformance.page(text) == text, "run: python docs/conformance.py"


def test_every_marker_names_a_behaviour() -> None:
    known = {
        match[1]
        for line in PAGE.read_text(encoding="utf-8").splitlines()
        if (match := conformance.ROW.match(line))
    }
    assert len(known) == 390
    assert set(conformance.marked_tests()) <= known
