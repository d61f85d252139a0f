"""`python -m tests.others.folder`: a line for each file, and a status that tells whether one has to be looked at."""

from __future__ import annotations

import multiprocessing
from pathlib import Path

import pytest

pytest.importorskip("can")
pytest.importorskip("cantools")
from tests.others import folder
from tests.others.log_comparison import compare_log

HEAD = 'VERSION ""\nBU_: ECU\n'


@pytest.mark.skipif(
    "fork" not in multiprocessing.get_all_start_methods(), reason="a process is forked for it"
)
def test_a_line_for_each_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "drive.log").write_text("(1.000000) can0 123#11\n(1.5) can1 12345678#\n")
    (tmp_path / "again.log").write_bytes((tmp_path / "drive.log").read_bytes())
    (tmp_path / "words.log").write_text("no log at all\n")
    (tmp_path / "car.dbc").write_text(f'{HEAD}BO_ 1 One: 1 ECU\n SG_ A : 0|8@1+ (1,0) [0|0] "" ECU\n')
    (tmp_path / "broken.dbc").write_text("BO_")
    assert folder.main([str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0].split() for line in lines[:-2]] == [
        ["log", "same", "again.log"],
        ["database", "refused", "broken.dbc"],
        ["database", "same", "car.dbc"],
        ["log", "refused", "words.log"],
    ]
    assert lines[-2].startswith("log, same 1, alone 0")


def test_a_difference_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "drive.log"
    path.write_text("(1.000000) can0 123#11\n")
    other = [((0x123, False, False, False, b"\x12"), 1.0, "can0", True)]
    monkeypatch.setattr("tests.others.log_comparison.python_can_reading", lambda path: (other, ""))
    told = compare_log(path)
    assert told.outcome == "differs"
    assert "frame 0" in told.detail
