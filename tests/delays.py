"""Threads that take another order: `python -m tests.delays FILES... --tests TESTS...`.

Before each statement in the functions of these files (or folders of them), one after the other, each process sleeps for
a moment, a few times: long enough for its other threads, and for other processes, to overtake it. A statement at which
a test fails twice is printed, and the status is 1. Load shows such an order once in hundreds of runs, this shows where
it is; but it takes as many runs as there are statements, or the `--share` of them that is drawn.
"""

from __future__ import annotations

import argparse
import ast
import random
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.mutants.judging import CPU_S, Outcome, Tree, core_files

ROOT = Path(__file__).resolve().parents[1]
SPAN_S, TIMES = 0.15, 6  # of each delay, and how often each process has one
_DELAY = """
import itertools as _itertools, time as _time
_turns = _itertools.count()
def _delay(): _time.sleep({span_s} if next(_turns) < {times} else 0)
"""


def statements(source: str) -> list[int]:
    """The lines at which a statement of a function begins, in order; no docstrings, and no properties."""
    lines = source.splitlines()
    found = {
        statement.lineno
        for function in ast.walk(ast.parse(source))
        if isinstance(function, ast.FunctionDef)
        and "property" not in map(ast.unparse, function.decorator_list)
        for statement in _within(function)
    }
    return [line for line in sorted(found) if not lines[line - 1].lstrip().startswith(("elif ", "@"))]


def _within(node: ast.AST) -> Iterator[ast.stmt]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.ExceptHandler | ast.match_case):
            yield from _within(child)
        elif isinstance(child, ast.stmt) and not isinstance(child, ast.FunctionDef | ast.ClassDef):
            if not _text(child):
                yield child
            yield from _within(child)


def delayed(source: str, line: int, span_s: float = SPAN_S, times: int = TIMES) -> str:
    """The source with a delay before the statement at this line."""
    lines = source.splitlines()
    text = lines[line - 1]
    lines.insert(line - 1, text[: len(text) - len(text.lstrip())] + "_delay()")
    head = [
        node.end_lineno or 0
        for node in ast.parse(source).body
        if _text(node) or (isinstance(node, ast.ImportFrom) and node.module == "__future__")
    ]
    lines.insert(max(head, default=0), _DELAY.format(span_s=span_s, times=times))
    return "\n".join(lines) + "\n"


def _text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def main(words: list[str] | None = None) -> int:
    arguments = options().parse_args(words)
    core = core_files(ROOT)
    files = [
        file for path in arguments.files for file in (sorted(path.rglob("*.py")) if path.is_dir() else [path])
    ]
    names = [file.resolve().relative_to(ROOT).as_posix() for file in files]
    places = [
        (name, line) for name in names if name not in core for line in statements((ROOT / name).read_text())
    ]
    chance = random.Random(arguments.seed)
    drawn = sorted(chance.sample(places, round(len(places) * arguments.share)))
    print(f"{len(drawn)} of {len(places)} statements", flush=True)
    found = 0
    with tempfile.TemporaryDirectory(prefix="cwd") as home:
        tree = Tree(ROOT, Path(home), compiled=True)
        for name, line in drawn:
            outcome = run(tree, name, line, arguments.tests)
            if outcome.end != "passed" and run(tree, name, line, arguments.tests).end != "passed":
                found += 1
                print(f"{name}:{line}: {outcome.by or 'the time limit'}", flush=True)
    print(f"{found} of them let a test fail")
    return int(found > 0)


def run(tree: Tree, name: str, line: int, tests: list[str]) -> Outcome:
    """These tests with a delay at this line of the tree's file."""
    with tree.changed(name, lambda source: delayed(source, line)):
        return tree.run(tests, [], CPU_S[True])


def options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="tests.delays", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE")
    parser.add_argument(
        "--tests", nargs="+", required=True, metavar="TEST", help="files or names, as for pytest"
    )
    parser.add_argument("--share", type=float, default=1.0, help="of the statements, 0 to 1")
    parser.add_argument("--seed", type=int, default=1)
    return parser


if __name__ == "__main__":
    sys.exit(main())
