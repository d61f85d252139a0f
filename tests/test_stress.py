"""tests/stress.py counts what fails under load, and ends its busy loops."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from tests import stress
from tests.hubs import LONG_S

EVERY_OTHER = """
from pathlib import Path

def test_every_other_time():
    mark = Path(__file__).with_name("mark")
    mark.rmdir() if mark.exists() else mark.mkdir()
    assert mark.exists()

def test_always():
    assert True
"""


@pytest.fixture(autouse=True)
def _runs_print_into_the_test_s_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))


@pytest.fixture
def flaky(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file of tests of which one fails every other time; nothing of ours is loaded there."""
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # half of what a run of theirs takes
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    path = tmp_path / "test_flaky.py"
    path.write_text(EVERY_OTHER)
    return path


def test_it_counts_what_fails_and_how_often(flaky: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert stress.main([str(flaky), "--times", "4", "--loops", "1"]) == 1
    rows = capsys.readouterr().out.splitlines()
    assert rows[0] == "| failed in 4 runs | test |"
    assert [row for row in rows if "::" in row] == ["| 2 | test_flaky.py::test_every_other_time |"]


def test_nothing_failed(flaky: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        stress.main(
            [f"{flaky}::test_always", "--times", "1", "--copies", "2", "--loops", "0", "--", "--tb=short"]
        )
        == 0
    )
    assert "::" not in capsys.readouterr().out


def test_copies_share_no_temporary_folder(flaky: Path) -> None:
    """One of ten that ended at the same moment failed, since pytest removed a folder that another one did, too."""
    flaky.write_text(
        "import os\n"
        "from pathlib import Path\n"
        "def test_says_where(tmp_path):\n"
        "    Path(__file__).with_name(f'seen-{os.getpid()}').write_text(str(tmp_path.parents[2]))\n"
    )
    assert stress.main([str(flaky), "--times", "1", "--copies", "2", "--loops", "0"]) == 0
    assert len({seen.read_text() for seen in flaky.parent.glob("seen-*")}) == 2


def test_a_run_without_results_has_failed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert stress.main([str(tmp_path / "not_there.py"), "--times", "1", "--loops", "0"]) == 1
    assert "| 1 | (the run itself: pytest ended with status 4) |" in capsys.readouterr().out


def test_loops_end_with_whoever_started_them() -> None:
    code = (
        "import os, signal\n"
        "from tests.stress import busy\n"
        "with busy(2) as loops:\n"
        "    print(flush=True)\n"
        "    os.kill(os.getpid(), signal.SIGTERM)\n"
        "    signal.pause()\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code],
        cwd=Path(__file__).parent.parent,
        stdout=subprocess.PIPE,  # the loops hold it, too: it ends when the last of them has
        timeout=LONG_S,
    )
    assert ended.stdout == os.linesep.encode()
