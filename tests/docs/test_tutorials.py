"""The tutorials' blocks run in the order in which they are printed, and show what is printed below them."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path
from typing import Any

import pytest

from tests.docs.blocks import run_console, run_python, run_tests

TUTORIALS = Path(__file__).resolve().parents[2] / "docs" / "tutorials"
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```)?", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"^<!-- file: (\S+) -->\n```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
PASSED = re.compile(r"^(\d+) passed", re.MULTILINE)
NUMBERS = {"sixty-three": 63}


def test_the_lab_in_fifteen_minutes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    space: dict[str, Any] = {"__name__": "tutorial"}
    blocks = BLOCK.findall((TUTORIALS / "lab.md").read_text(encoding="utf-8"))
    assert len(blocks) >= 6
    for code, shown in blocks:
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            exec(compile(code, "<lab.md>", "exec"), space)
        assert output.getvalue() == shown, code
    assert "$enddefinitions" in (tmp_path / "can0.vcd").read_text()


def test_tests_for_an_ecu(tmp_path: Path) -> None:
    text = (TUTORIALS / "ecu-tests.md").read_text(encoding="utf-8")
    files = dict(FILE.findall(text))
    assert set(files) == {"lamp.py", "test_lamp.py"}
    for name, code in files.items():
        (tmp_path / name).write_text(code)
    passed = PASSED.search(run_tests(tmp_path))
    assert passed is not None
    said = next(number for word, number in NUMBERS.items() if f"The {word} tests" in text)
    assert int(passed[1]) == said


def test_programs_on_shared_boards(tmp_path: Path) -> None:
    page = TUTORIALS / "shared-boards.md"
    assert run_python(page) == 4
    printed = run_console(page, tmp_path)
    assert "HW000001:1" in printed
