"""The texts that people read: pages of the documentation, docstrings, messages and help texts of the source."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "src" / "canwire"
NOT_OURS = (  # copied from the reference, or generated from it
    "docs/reference",
    "docs/conformance.md",
    "docs/iso-16845.md",
)
MESSAGE_WORDS = 5  # a string of fewer words is a name, an option or a format


class Text(NamedTuple):
    """One sentence, docstring or message, and where it is."""

    path: Path
    line: int
    words: str

    def __str__(self) -> str:
        return f"{self.path.relative_to(ROOT)}:{self.line}: {self.words}"


def pages() -> list[Path]:
    """Every page in Markdown that canwire's authors wrote."""
    found = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").rglob("*.md")]
    return sorted(page for page in found if not str(page.relative_to(ROOT)).startswith(NOT_OURS))


def sources() -> list[Path]:
    """Every Python file of the package, and the page's scripts and documents."""
    return sorted(
        path
        for path in SOURCES.rglob("*")
        if path.suffix in (".py", ".pxd", ".js", ".html", ".css") and "vendor" not in path.parts
    )


def sentences(page: Path) -> Iterator[Text]:
    """The sentences of a page's paragraphs and lists, without code, tables, pictures and headings."""
    text = page.read_text("utf-8")
    blanked = re.sub(r"```.*?```|<!--.*?-->", lambda block: "\n" * block[0].count("\n"), text, flags=re.S)
    line = 1
    for paragraph in re.split(r"(\n\s*\n|\n(?=\s*[-*] ))", blanked):
        start, line = line + leading_lines(paragraph), line + paragraph.count("\n")
        words = " ".join(paragraph.split())
        if (
            words
            and not words.startswith(("#", "|", "![", "    ", "$"))
            and not paragraph.lstrip("\n").startswith("    ")
        ):
            for sentence in re.split(r"(?<=[.!?]) +(?=[A-Z`*\[])", words):
                if len(sentence.split()) > 3:
                    yield Text(page, start, sentence)


def leading_lines(paragraph: str) -> int:
    """How many line ends there are before its first word."""
    return paragraph[: len(paragraph) - len(paragraph.lstrip())].count("\n")


def docstrings(path: Path) -> Iterator[Text]:
    """The docstrings of a file's public module, classes and functions, with their names."""
    tree = ast.parse(path.read_text("utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            name = getattr(node, "name", path.stem)
            if (text := ast.get_docstring(node)) and (not name.startswith("_") or name == "__init__"):
                yield Text(path, getattr(node, "lineno", 1), f"{name}: {text}")


def messages(path: Path) -> Iterator[Text]:
    """The strings of a file that read as sentences: errors, warnings, help texts."""
    tree = ast.parse(path.read_text("utf-8"))
    documented = {id(node.body[0].value) for node in ast.walk(tree) if has_docstring(node)}  # type: ignore[attr-defined]
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            words = "".join(
                str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in documented:
            words = node.value
        else:
            continue
        if len(words.split()) >= MESSAGE_WORDS:
            yield Text(path, node.lineno, " ".join(words.split()))


def has_docstring(node: ast.AST) -> bool:
    """Whether its body begins with a string."""
    body = getattr(node, "body", None)
    return (
        isinstance(body, list)
        and bool(body)
        and isinstance(body[0], ast.Expr)
        and isinstance(body[0].value, ast.Constant)
    )
