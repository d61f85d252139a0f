"""docs/time.md as it stands: five programs of five interfaces, in lockstep, are the same every time."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.cold import entry_points
from tests.docs.blocks import blocks
from tests.lockstep.programs import PAGE, bench, five_programs, page_serves

pytest.importorskip("can")
pytest_plugins = ["pytester"]
RUNS = int(os.environ.get("CANWIRE_LOCKSTEP_RUNS", "2"))


def heard(home: Path, seed: str) -> str:
    with bench(home, *page_serves()) as made:
        return made.run(five_programs(), seed)["log"]


@pytest.mark.conforms("G-17", "PL-01", "N-36")
def test_the_same_log_every_time_and_another_one_of_another_seed(tmp_path: Path) -> None:
    first = heard(tmp_path / "1", "1")
    assert {line.split()[1].partition("#")[0] for line in first.splitlines()} >= {
        "101", "102", "103", "111", "112", "120", "7DF"
    }  # fmt: skip
    for number in range(2, RUNS + 1):
        assert heard(tmp_path / str(number), "1") == first
    assert heard(tmp_path / "other", "2") != first


@pytest.mark.conforms("PL-05", "G-17")
def test_the_fixture_of_the_page(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    block = next(block for block in blocks(PAGE) if block.mark == "file: test_lockstep.py")
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv(
        "PYTHONPATH", os.pathsep.join([entry_points(pytester.path), os.environ.get("PYTHONPATH", "")])
    )
    pytester.makepyfile(
        block.text,
        test_failing="""
        def test_one_that_fails(canwire_lockstep):
            canwire_lockstep({"well": "import canwire; canwire.connect().sleep(1.0)", "ill": "raise OSError('ill')"})
        """,
    )
    result = pytester.runpytest("-p", "canwire.pytest_plugin", "-p", "no:cacheprovider")
    result.assert_outcomes(passed=1, failed=1)
    text = result.stdout.str()
    assert "AssertionError: ill failed:" in text
    assert "OSError: ill" in text
