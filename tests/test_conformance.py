"""docs/conformance.md says what the markers say, and the markers name behaviours and findings that exist."""

import re
from pathlib import Path

from docs import conformance
from tests.cases import each

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "conformance.md"


def test_the_page_is_what_the_markers_say() -> None:
    behaviours = conformance.BEHAVIOURS.read_text(encoding="utf-8")
    shown = PAGE.read_text(encoding="utf-8")
    assert conformance.page(behaviours) == shown, "run: python docs/conformance.py"


def test_every_marker_names_a_behaviour() -> None:
    known = {
        match[1]
        for line in conformance.BEHAVIOURS.read_text(encoding="utf-8").splitlines()
        if (match := conformance.ROW.match(line))
    }
    assert len(known) == 416
    assert set(conformance.marked_tests()) <= known


POINTS = [point for points in conformance.findings().values() for point in points]


def test_every_finding_is_shown_or_decided() -> None:
    """A point of an outside examination is mended by a test, or decided otherwise where it is said."""
    tests = conformance.marked_tests("finding")
    assert [point.name for point in POINTS if not (point.name in tests or point.decided)] == []


def test_every_marker_names_a_finding() -> None:
    examinations = {point.name.partition(" ")[0] for point in POINTS}
    marked = {name for name in conformance.marked_tests("finding") if name.partition(" ")[0] in examinations}
    assert marked <= {point.name for point in POINTS}


def test_where_a_finding_is_decided_there_is_a_place() -> None:
    """`docs/page.md#heading: why`, or `ruling 31: why`."""
    for point in POINTS:
        for place, heading in re.findall(r"(docs/[\w./-]+\.md)(?:#([\w-]+))?", point.decided):
            text = (ROOT / place).read_text(encoding="utf-8")
            assert not heading or heading in _anchors(text), f"{point.name}: {place}#{heading}"
        assert not point.decided or re.match(r"docs/[\w./-]+\.md|ruling \d+", point.decided), point


def _anchors(text: str) -> set[str]:
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading).strip().lower().replace(" ", "-") for heading in headings}


EXAMINATIONS = {
    "vci": ("vci.md", r"^### (F\d+) "),
    "candrv": ("candrv.md", r"^([AB]\d+)\. "),
    "acan": ("acan-dongle.md", r"^### (A\d+) "),
    "linux": ("linux.md", r"^### (\d)\. "),
    "dialects": ("dialects.md", r"^(\d+)\. "),
    "python-can": ("python-can.md", r"^### (\d+)\.? "),
    "page": ("page.md", r"^(\d+)\. "),
}
SMALL_ONES = {"vci": "F12", "acan": "A15", "python-can": "10"}  # points with a list of their own


@each("name", EXAMINATIONS)
def test_no_finding_is_left_out(name: str) -> None:
    file, numbered = EXAMINATIONS[name]
    text = (ROOT / "docs" / "reference" / "findings" / file).read_text(encoding="utf-8")
    numbers = re.findall(numbered, text, re.MULTILINE)
    assert numbers
    listed = [point.name.partition(" ")[2] for point in POINTS if point.name.partition(" ")[0] == name]
    assert set(numbers) <= {number.partition(".")[0] for number in listed}
    if small := SMALL_ONES.get(name):
        section = re.split(rf"^### {small}\b.*$", text, flags=re.MULTILINE)[1].partition("\n## ")[0]
        bullets = re.findall(r"^- ", section, re.MULTILINE)
        assert len([number for number in listed if number.startswith(f"{small}.")]) == len(bullets)
