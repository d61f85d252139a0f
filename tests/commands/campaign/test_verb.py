"""`canwire campaign`: its account, its exit status, and a run again."""

from __future__ import annotations

from pathlib import Path

import pytest

from canwire import CampaignRun
from canwire.commands import main
from canwire.commands.campaign.progress import Progress
from tests.campaigns.scripts import FLIPS, written


@pytest.fixture
def flips(tmp_path: Path) -> str:
    return str(written(tmp_path, "flips.py", FLIPS))


@pytest.mark.conforms("N-37")
def test_what_failed_is_said_with_the_way_to_repeat_it(
    flips: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["campaign", flips, "--runs", "24", "--seed", "3", "--workers", "1"]) == 1
    lines = capsys.readouterr().out.splitlines()
    again = lines[-1].removeprefix("again: canwire ").split()
    log = tmp_path / "run.log"
    assert main([*again, "--log", str(log)]) == 1
    shown = capsys.readouterr().out
    assert lines[0] in shown
    assert "AssertionError" in shown
    assert len(log.read_text().splitlines()) == 20
    first = log.read_bytes()
    assert main([*again, "--log", str(log)]) == 1
    assert log.read_bytes() == first


def test_all_well(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = FLIPS.replace("1e-2", "1e-6")
    table = tmp_path / "well.csv"
    assert (
        main(["campaign", str(written(tmp_path, "well.py", text)), "--workers", "1", "--results", str(table)])
        == 0
    )
    assert capsys.readouterr().out == "12 runs: 12 passed, 0 did not\n"
    assert len(table.read_text().splitlines()) == 13


def test_no_such_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", str(tmp_path / "none.py")]) == 2
    assert "none.py" in capsys.readouterr().err


@pytest.mark.conforms("N-37")
def test_resumed_and_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C after three runs, then the same command."""
    path = str(written(tmp_path, "well.py", FLIPS.replace("1e-2", "1e-6")))
    table, report = tmp_path / "well.csv", tmp_path / "well.xml"
    command = ["campaign", path, "--workers", "1", "--results", str(table), "--report", str(report)]
    count = Progress.count

    def counted(self: Progress, run: CampaignRun) -> None:
        count(self, run)
        if self.done == 3:
            raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Progress, "count", counted)
        main(command)
    assert len(table.read_text().splitlines()) == 4
    capsys.readouterr()
    assert main(command) == 0
    assert capsys.readouterr().out == (
        "3 runs were done before, 9 were played now\n12 runs: 12 passed, 0 did not\n"
    )
    assert len(table.read_text().splitlines()) == 13
    assert report.read_text().count("<testcase") == 12
