"""Writes docs/conformance.md from the numbers that stand on the tests.

    python docs/conformance.py

The list of behaviours is docs/reference/behaviours.md, that of the findings docs/findings.toml.
"""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "conformance.md"
BEHAVIOURS = ROOT / "docs" / "reference" / "behaviours.md"
ROW = re.compile(r"^\| ([A-Z][A-Z0-9]?-\d+) \| (.*?) \|")
GROUP = re.compile(r"^## (.*)$")
HEAD = """# Conformance

Which behaviour is shown by which test. Written by `python docs/conformance.py` from the `conforms` markers of the
tests: change those, not this page. {shown} of {total} behaviours are shown. At the end: what outside examinations
found, and what became of it.
"""
FINDINGS = ROOT / "docs" / "findings.toml"
FINDINGS_HEAD = """
## Findings

Each point of an outside examination is shown mended by tests with the marker `finding`, or decided otherwise, where it
is said. The list is `docs/findings.toml`. {shown} of {total} points are shown by tests.
"""


class Point(NamedTuple):
    """A point of an examination: its marker ("vci F3"), what it is about, and where it was decided otherwise, or ""."""

    name: str
    what: str
    decided: str


def findings() -> dict[str, list[Point]]:
    """Points by the title of the examination."""
    found = tomllib.loads(FINDINGS.read_text(encoding="utf-8"))
    return {table["title"]: list(_points(name, table)) for name, table in found.items()}


def _points(name: str, table: dict[str, Any]) -> Iterator[Point]:
    decided = table.get("decided", {})
    for point, what in table.items():
        if point not in ("title", "decided"):
            yield Point(f"{name} {point}", what, decided.get(point, ""))


def marked_tests(marker: str = "conforms") -> dict[str, list[str]]:
    """Test names by behaviour number, or by the point of a "finding"."""
    found: dict[str, set[str]] = {}
    for path, name, kind, number in _all_marks():
        if kind == marker:
            found.setdefault(number, set()).add(f"{path}::{name}")
    return {number: sorted(tests) for number, tests in found.items()}


@cache
def _all_marks() -> list[tuple[str, str, str, str]]:
    """The file, the test, the marker and its number, of all tests."""
    found = []
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        place = path.relative_to(ROOT).as_posix()
        found += [(place, *mark) for mark in (*_module_marks(tree), *_marks(tree))]
    return found


def _marks(tree: ast.AST, outer: tuple[str, ...] = ()) -> Iterator[tuple[str, str, str]]:
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef):
            yield from _numbers("::".join((*outer, node.name)), node.decorator_list)
            yield from _marks(node, (*outer, node.name))
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield from _numbers("::".join((*outer, node.name)), node.decorator_list)


def _module_marks(tree: ast.Module) -> Iterator[tuple[str, str, str]]:
    for node in tree.body:
        if isinstance(node, ast.Assign) and any(
            isinstance(t, ast.Name) and t.id == "pytestmark" for t in node.targets
        ):
            yield from _numbers("*", [node.value])


def _numbers(name: str, decorators: list[ast.expr]) -> Iterator[tuple[str, str, str]]:
    for decorator in decorators:
        for call in ast.walk(decorator):
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute):
                for argument in call.args:
                    if isinstance(argument, ast.Constant):
                        yield name, call.func.attr, str(argument.value)


def page(behaviours: str) -> str:
    """The page for this list of behaviours."""
    tests = marked_tests()
    lines: list[str] = []
    total = shown = 0
    for line in behaviours.splitlines():
        group, row = GROUP.match(line), ROW.match(line)
        if group:
            lines += ["", f"## {group[1]}", "", "| # | behaviour | shown by |", "|---|---|---|"]
        elif row:
            total += 1
            names = tests.get(row[1], [])
            shown += bool(names)
            lines.append(
                f"| {row[1]} | {row[2]} | {'<br>'.join(f'`{name}`' for name in names) or 'not yet'} |"
            )
    return HEAD.format(shown=shown, total=total) + "\n".join(lines) + "\n" + findings_section()


def findings_section() -> str:
    """What became of every point."""
    tests, examinations = marked_tests("finding"), findings()
    lines: list[str] = []
    for title, points in examinations.items():
        lines += [
            "",
            f"### {title}",
            "",
            "| point | what | test, or where it is decided otherwise |",
            "|---|---|---|",
        ]
        for point in points:
            shown_by = [f"`{name}`" for name in tests.get(point.name, [])]
            told = "<br>".join([*shown_by, *filter(None, [point.decided])])
            lines.append(f"| {point.name} | {point.what} | {told or 'open'} |")
    every = [point for points in examinations.values() for point in points]
    shown = sum(point.name in tests for point in every)
    return FINDINGS_HEAD.format(shown=shown, total=len(every)) + "\n".join(lines) + "\n"


def main() -> int:
    PAGE.write_text(page(BEHAVIOURS.read_text(encoding="utf-8")), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
