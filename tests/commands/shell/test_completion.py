"""Completion: what shells are told, and what they are answered."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from canwire import ExtraMissing
from canwire.commands import VERBS, main

pytest.importorskip("argcomplete")
pytestmark = pytest.mark.finding("newcomer F13")


@pytest.mark.parametrize(("shell", "has"), [
    ("bash", "complete -o nospace -o default -o bashdefault -F _python_argcomplete canwire"),
    ("zsh", "compdef _python_argcomplete canwire"),
    ("fish", "complete --command canwire"),
])  # fmt: skip
def test_the_code_of_a_shell(capsys: pytest.CaptureFixture[str], shell: str, has: str) -> None:
    assert main(["completion", shell]) == 0
    assert has in capsys.readouterr().out


def answers(line: str, folder: Path) -> list[str]:
    """What a shell is told when the cursor is at the end of the line."""
    told = folder / "told"
    environment = {
        **os.environ,
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(told),
        "_ARGCOMPLETE_IFS": "\n",
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
        "COMP_TYPE": "9",
    }
    ended = subprocess.run(
        [sys.executable, "-m", "canwire"], env=environment, capture_output=True, text=True, timeout=60
    )
    assert ended.stderr == ""
    return told.read_text().split("\n")


def test_verbs_are_completed(tmp_path: Path) -> None:
    found = {word.strip() for word in answers("canwire ", tmp_path)}
    assert set(VERBS) <= found


@pytest.mark.parametrize(("line", "expected"), [
    ("canwire dump --da", ["--data-bit-rate "]),
    ("canwire lin sche", ["schedule "]),
    ("canwire lin schedule --ro", ["--rounds "]),
    ("canwire completion z", ["zsh "]),
])  # fmt: skip
def test_options_and_sub_verbs_are_completed(tmp_path: Path, line: str, expected: list[str]) -> None:
    assert answers(line, tmp_path) == expected


def test_without_argcomplete_one_line_names_the_extra(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "argcomplete.shell_integration", None)
    assert main(["completion", "bash"]) == 2
    assert capsys.readouterr().err == f"canwire: {ExtraMissing('argcomplete', 'tools')}\n"
