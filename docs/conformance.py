"""Writes docs/conformance.md from the numbers that stand on the tests.

    python docs/conformance.py ../shared/behaviours.md

The list of behaviours is read from the file given, or else from the page as it stands.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "conformance.md"
ROW = re.compile(r"^\| ([A-Z][A-Z0-9]?-\d+) \| (.*?) \|")
GROUP = re.compile(r"^## (.*)$")
HEAD = """# Conformance

Which behaviour is shown by which test. Written by `python docs/conformance.py` from the `conforms` markers of the
tests: change those, not this page. {shown} of {total} behaviours are shown.
"""


def marked_tests() -> dict[str, list[str]]:
    """Test names by behaviour number."""
    found: dict[str, list[str]] = {}
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for name, number in (*_module_marks(tree), *_marks(tree)):
            found.setdefault(number, []).append(f"{path.relative_to(ROOT).as_posix()}::{name}")
    return {number: sorted(set(tests)) for number, tests in found.items()}


def _marks(tree: ast.AST, outer: tuple[str, ...] = ()) -> Iterator[tuple[str, str]]:
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef):
            yield from _numbers("::".join((*outer, node.name)), node.decorator_list)
            yield from _marks(node, (*outer, node.name))
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield from _numbers("::".join((*outer, node.name)), node.decorator_list)


def _module_marks(tree: ast.Module) -> Iterator[tuple[str, str]]:
    for node in tree.body:
        if isinstance(node, ast.Assign) and any(
            isinstance(t, ast.Name) and t.id == "pytestmark" for t in node.targets
        ):
            yield from _numbers("*", [node.value])


def _numbers(name: str, decorators: list[ast.expr]) -> Iterator[tuple[str, str]]:
    for decorator in decorators:
        for call in ast.walk(decorator):
            if (
                isinstance(call, ast.Call)
                and isinstance(call.func, ast.Attribute)
                and call.func.attr == "conforms"
            ):
                for argument in call.args:
                    if isinstance(argument, ast.Constant):
                        yield name, str(argument.value)


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
    return HEAD.format(shown=shown, total=total) + "\n".join(lines) + "\n"


def main() -> int:
    source = Path(sys.argv[1]) if len(sys.argv) > 1 else PAGE
    PAGE.write_text(page(source.read_text(encoding="utf-8")), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
