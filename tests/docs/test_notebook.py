"""The notebook's cells run, in order and with await at the top, and print what stands below them in the file."""

from __future__ import annotations

import ast
import asyncio
import contextlib
import inspect
import io
import json
from typing import Any

import pytest

from tests.docs.blocks import ROOT

NOTEBOOK = ROOT / "docs" / "notebook.ipynb"


def printed(cell: dict[str, Any]) -> str:
    streams = [output["text"] for output in cell["outputs"] if output["output_type"] == "stream"]
    return "".join("".join(text) for text in streams)


async def run_cells(cells: list[dict[str, Any]]) -> None:
    space: dict[str, Any] = {"__name__": "notebook"}
    for cell in cells:
        source = "".join(cell["source"])
        code = compile(source, str(NOTEBOOK), "exec", flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            result = eval(code, space)
            if inspect.iscoroutine(result):
                await result
        assert output.getvalue() == printed(cell), source


def test_the_notebook_shows_what_it_prints(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib", reason="the notebook needs matplotlib: canwire[docs]")
    monkeypatch.setenv("MPLBACKEND", "agg")
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert len(code) >= 5
    asyncio.run(run_cells(code))
