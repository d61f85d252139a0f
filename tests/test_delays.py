"""tests/delays.py puts its delays where threads may overtake each other, and finds where a test does not bear it."""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

import pytest

from tests import delays

SOURCE = '''"""A module."""

from __future__ import annotations


class Thing:
    """A thing."""

    @property
    def known(self) -> bool:
        return True

    def work(self, turns: int) -> list[int]:
        """Work."""
        found = []
        for turn in range(turns):
            if turn == 1:
                found.append(turn)
            elif turn:
                pass
            else:
                found.append(-1)
        try:
            int("x")
        except ValueError:
            found.append(7)
        return found
'''
RACE = """
from __future__ import annotations

import threading


def told() -> list[str]:
    words: list[str] = []
    answer = threading.Timer(0.05, words.append, ["answer"])
    answer.start()
    words.append("question")
    answer.join()
    return words
"""


def test_the_statements_of_functions_can_be_delayed_and_nothing_else() -> None:
    lines = SOURCE.splitlines()
    assert [lines[line - 1].strip() for line in delays.statements(SOURCE)] == [
        "found = []", "for turn in range(turns):", "if turn == 1:", "found.append(turn)", "pass", "found.append(-1)",
        "try:", 'int("x")', "found.append(7)", "return found",
    ]  # fmt: skip


def test_a_delayed_source_does_the_same_later() -> None:
    for line in delays.statements(SOURCE):
        there: dict[str, object] = {}
        exec(compile(delays.delayed(SOURCE, line, span_s=0.001, times=1), "thing.py", "exec"), there)
        began = time.monotonic()
        assert there["Thing"]().work(3) == [-1, 1, 7]  # type: ignore[operator]
        assert time.monotonic() - began >= 0.001


def test_an_order_of_threads_that_a_test_does_not_bear_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    files = {
        "src/canwire/race.py": RACE,
        "src/canwire/__init__.py": "",
        "setup.py": "",
        "pytest.ini": "[pytest]",
    }
    files["tests/test_race.py"] = (
        "from canwire.race import told\ndef test_order():\n    assert told() == ['question', 'answer']\n"
    )
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    for words in (["init", "-q"], ["add", "."]):
        subprocess.run(
            ["git", *words], cwd=tmp_path, check=True, env={**os.environ, "GIT_CONFIG_GLOBAL": os.devnull}
        )
    monkeypatch.setattr(delays, "ROOT", tmp_path)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    race = tmp_path / "src/canwire/race.py"
    question = 1 + RACE.splitlines().index('    words.append("question")')
    monkeypatch.setattr(delays, "statements", lambda source: [question - 2, question])
    assert delays.main([str(race), "--tests", "tests/test_race.py"]) == 1
    said = capsys.readouterr().out.splitlines()
    assert said[0] == "2 of 2 statements"
    assert said[1].startswith(f"src/canwire/race.py:{question}: tests/test_race.py::test_order")
    assert said[2:] == ["1 of them let a test fail"]
