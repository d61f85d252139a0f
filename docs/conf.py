"""Sphinx: `sphinx-build -W docs build/site` makes the documentation as a site. Needs canwire[docs]."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import msgspec

import api_pages

project = "canwire"
author = "canwire's authors"
project_copyright = "canwire's authors, MIT licence"
version = release = re.findall(
    r'"(.+?)"', (Path(__file__).parent.parent / "src/canwire/version.py").read_text(encoding="utf-8")
)[0]
extensions = ["myst_nb", "sphinx.ext.autodoc"]
nb_execution_mode = "off"  # tests/docs/test_notebook.py runs the cells; the page shows what they printed
myst_heading_anchors = 3
html_theme = "furo"
html_title = "canwire"
html_static_path = ["_static"]
html_css_files = ["canwire.css"]
exclude_patterns = ["**/__pycache__", "reference/findings"]
suppress_warnings = ["myst.xref_missing"]  # pages also link to the source's files, which are no pages
autodoc_member_order = "bysource"
autodoc_typehints = "signature"

NOT_SEARCHED = re.compile(r"conformance|iso-16845|architecture|roadmap|tests|reference/.*|.*-map")
"""For contributors: long lists of facts that would come before the guides in what a search finds."""


def leave_out_of_search(app: Any, doctree: object) -> None:
    if NOT_SEARCHED.fullmatch(app.env.docname):
        app.env.metadata[app.env.docname]["nosearch"] = "true"


_MAP = (Path(__file__).parent / "architecture.md").read_text(encoding="utf-8")
SEAMS = frozenset(re.findall(r"`(\w+\.\w+)`", _MAP.partition("\n## Seams\n")[2].partition("\n## ")[0]))
"""Methods that are there for canwire's own files: architecture.md lists them, the library's pages leave them out."""


def leave_out(
    _app: object, _what: str, _name: str, found: object, skip: bool, _options: object
) -> bool | None:
    """Seams, descriptors that answer other libraries' names, and fields of named tuples, which have no text."""
    left = type(found).__name__ in ("WrongName", "_tuplegetter")
    return True if left or getattr(found, "__qualname__", "") in SEAMS else None


def plain_signature(
    _app: object, _what: str, _name: str, found: object, _options: object, _signature: str, _result: str
) -> tuple[str, None] | None:
    """Of the tables of canwire.toml only the names: the page of that file has their types, limits and defaults."""
    if not (isinstance(found, type) and issubclass(found, msgspec.Struct)):
        return None
    return f"(*, {', '.join(field.name for field in msgspec.structs.fields(found))})", None


def plain_docstring(
    _app: object, _what: str, _name: str, _object: object, _options: object, lines: list[str]
) -> None:
    """Docstrings are plain text: `names` stand in backticks, and CAN_ERROR_ is no link."""
    for number, line in enumerate(lines):
        marked = re.sub(r"(?<!`)`([^`]+)`(?!`)", r"``\1``", line)
        lines[number] = re.sub(r"(\w)_(?![\w`])", r"\1\\_", marked)


def setup(app: Any) -> None:
    api_pages.write()
    app.connect("doctree-read", leave_out_of_search)
    app.connect("autodoc-skip-member", leave_out)
    app.connect("autodoc-process-signature", plain_signature)
    app.connect("autodoc-process-docstring", plain_docstring)
