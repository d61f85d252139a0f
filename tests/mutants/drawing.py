"""Which small changes of the source there are, and a draw of some of them by a seed."""

from __future__ import annotations

import ast
import random
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

PACKAGE = Path("src/canwire")
COMPARED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
COMPUTED: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.FloorDiv,
    ast.FloorDiv: ast.Mult,
    ast.Div: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.Pow: ast.Mult,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitOr,
}
UNSEEN_FIELDS = {"annotation", "returns", "decorator_list", "bases", "type_params"}


class Mutant(NamedTuple):
    """One change: where the text `before` stands and what stands there instead; `inside` is the function or class."""

    file: str
    line: int
    column: int
    before: str
    after: str
    inside: str

    def applied(self, source: str) -> str:
        """The source with this change."""
        lines = source.encode().splitlines(keepends=True)
        start = sum(map(len, lines[: self.line - 1])) + self.column
        text = source.encode()
        assert text[start:].startswith(self.before.encode()), self
        return (text[:start] + self.after.encode() + text[start + len(self.before.encode()) :]).decode()


def folders(root: Path, only: Collection[str] = ()) -> dict[str, list[Path]]:
    """The package's files by its top folders; those that stand in none are "." together.

    `only`: these folders, and files that stand in none, such as "bus" and "ring.py"; nothing means all.
    """
    found: dict[str, list[Path]] = {}
    for path in sorted((root / PACKAGE).rglob("*.py")):
        inner = path.relative_to(root / PACKAGE)
        if not only or inner.parts[0] in only:
            found.setdefault(inner.parts[0] if len(inner.parts) > 1 else ".", []).append(path)
    return found


def draw(root: Path, count: int, seed: int, only: Collection[str] = ()) -> list[Mutant]:
    """From each top folder so many mutants as it has lines, at least one; the same for the same seed and source."""
    drawn: list[Mutant] = []
    by_folder = folders(root, only)
    numbers = shares({name: sum(map(_lines, paths)) for name, paths in by_folder.items()}, count)
    for name, paths in by_folder.items():
        chance = random.Random(f"{seed} {name}")
        sites = [
            site
            for path in paths
            for site in sites_of(path.read_text("utf-8"), path.relative_to(root).as_posix())
        ]
        drawn += [chance.choice(site) for site in chance.sample(sites, min(numbers[name], len(sites)))]
    return drawn


def shares(lines: dict[str, int], count: int) -> dict[str, int]:
    """`count` in proportion to the lines, each at least one; what rounding leaves goes to the largest remainders."""
    exact = {name: number * count / sum(lines.values()) for name, number in lines.items()}
    found = {name: max(1, int(share)) for name, share in exact.items()}
    by_remainder = sorted(exact, key=lambda name: found[name] - exact[name])
    for name in by_remainder[: max(0, count - sum(found.values()))]:
        found[name] += 1
    return found


def sites_of(source: str, file: str) -> list[list[Mutant]]:
    """For each place of a file that can be changed: the ways to change it."""
    lines = source.encode().splitlines(keepends=True)
    found: list[list[Mutant]] = []
    for node, inside in _seen(ast.parse(source), ""):
        before = _text(lines, node) if isinstance(node, ast.expr | ast.stmt) else ""
        if before:
            place = (file, getattr(node, "lineno", 0), getattr(node, "col_offset", 0), before)
            found.append([Mutant(*place, after, inside) for after in dict.fromkeys(changes(node, before))])
    return [site for site in found if site]


def changes(node: ast.AST, before: str) -> Iterator[str]:
    """The texts that may stand in the place of this node, whose text is `before`."""
    match node:
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            yield f"({ast.unparse(ast.Compare(left, [COMPARED[type(op)]()], [right]))})"
        case ast.BinOp(left=left, op=op, right=right) if type(op) in COMPUTED and not (
            _text_like(left) or _text_like(right)
        ):
            yield f"({ast.unparse(ast.BinOp(left, COMPUTED[type(op)](), right))})"
        case ast.BoolOp(op=op, values=values):
            yield f"({ast.unparse(ast.BoolOp(ast.Or() if isinstance(op, ast.And) else ast.And(), values))})"
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield f"({ast.unparse(operand)})"
        case ast.Constant(value=bool(value)):
            yield str(not value)
        case ast.Constant(value=int(value) | float(value)):
            yield from (str(value + 1), f"({value - 1})")
        case ast.Return(value=ast.expr() as value) if ast.unparse(value) != "None":
            yield "return None"
        case (
            ast.Expr(value=ast.Call() | ast.Await())
            | ast.AugAssign()
            | ast.Raise()
            | ast.Delete()
            | ast.Continue()
            | ast.Break()
        ):
            yield "pass"
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]):
            yield "pass"
    if isinstance(node, ast.Name | ast.Attribute | ast.Call) and getattr(node, "is_condition", False):
        yield f"(not {before})"


def _seen(node: ast.AST, inside: str) -> Iterator[tuple[ast.AST, str]]:
    """The nodes that may be changed: no docstrings, types, texts of errors, nor what only other systems run."""
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        inside = f"{inside}.{node.name}".lstrip(".")
        if any("overload" in ast.unparse(decorator) for decorator in node.decorator_list):
            return
    if isinstance(node, ast.If | ast.While | ast.IfExp):
        node.test.is_condition = True  # type: ignore[attr-defined]
    yield node, inside
    for child in _children(node):
        yield from _seen(child, inside)


def _children(node: ast.AST) -> Iterable[ast.AST]:
    if isinstance(node, ast.JoinedStr | ast.Raise | ast.Assert | ast.Import | ast.ImportFrom):
        return ()
    if isinstance(node, ast.If | ast.IfExp):
        test = ast.unparse(node.test)
        if "TYPE_CHECKING" in test or "__name__" in test:
            return ()
        if "sys.platform" in test:
            elsewhere = "== 'win32'" in test or "== 'darwin'" in test
            return _listed(node.orelse if elsewhere else node.body)
    if isinstance(node, ast.Assign) and "__all__" in map(ast.unparse, node.targets):
        return ()
    if isinstance(node, ast.Module):  # names of types, joined with "|"
        return [
            one
            for one in node.body
            if not (
                isinstance(one, ast.Assign)
                and isinstance(one.value, ast.BinOp)
                and isinstance(one.value.op, ast.BitOr)
            )
        ]
    unseen = UNSEEN_FIELDS | ({"keywords"} if isinstance(node, ast.ClassDef) else set())
    return [child for name, value in ast.iter_fields(node) if name not in unseen for child in _listed(value)]


def _listed(value: object) -> list[ast.AST]:
    return [one for one in (value if isinstance(value, list) else [value]) if isinstance(one, ast.AST)]


def _text_like(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str | bytes)
    )


def _text(lines: list[bytes], node: ast.expr | ast.stmt) -> str:
    assert node.end_lineno is not None
    part = lines[node.lineno - 1 : node.end_lineno]
    part[-1] = part[-1][: node.end_col_offset]
    part[0] = part[0][node.col_offset :]
    return b"".join(part).decode()


def _lines(path: Path) -> int:
    return len(path.read_bytes().splitlines())


def found_again(root: Path, mutant: Mutant) -> Mutant | None:
    """The same change in today's source, whose lines may have moved; None where there is no such place any more."""
    path = root / mutant.file
    if not path.exists():
        return None
    there = [one for site in sites_of(path.read_text("utf-8"), mutant.file) for one in site]
    same = [
        one
        for one in there
        if (one.before, one.after, one.inside) == (mutant.before, mutant.after, mutant.inside)
    ]
    return min(
        same, key=lambda one: (abs(one.line - mutant.line), abs(one.column - mutant.column)), default=None
    )
