"""Sphinx: `sphinx-build -W docs build/site` makes the documentation as a site. Needs canwire[docs]."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

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
exclude_patterns = ["**/__pycache__", "reference/findings"]
suppress_warnings = ["myst.xref_missing"]  # pages also link to the source's files, which are no pages
autodoc_member_order = "bysource"
autodoc_typehints = "signature"


def plain_docstring(
    _app: object, _what: str, _name: str, _object: object, _options: object, lines: list[str]
) -> None:
    """Docstrings are plain text: `names` stand in backticks, and CAN_ERROR_ is no link."""
    for number, line in enumerate(lines):
        marked = re.sub(r"(?<!`)`([^`]+)`(?!`)", r"``\1``", line)
        lines[number] = re.sub(r"(\w)_(?![\w`])", r"\1\\_", marked)


def setup(app: Any) -> None:
    app.connect("autodoc-process-docstring", plain_docstring)
