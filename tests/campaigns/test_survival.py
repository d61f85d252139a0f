"""A run may end itself, its process and that process's keeper: it is one row, and the others are played."""

from __future__ import annotations

import fcntl
from collections import Counter
from pathlib import Path

import pytest

from canwire import CampaignRun, HubError, repeat_run, run_campaign
from tests.campaigns.scripts import WILD, written

pytestmark = pytest.mark.usefixtures("warm_workers")


def wild(folder: Path, *ways: str) -> Path:
    return written(folder, "wild.py", WILD.replace("WAYS", repr(ways)))


ENDS = {
    "leave": ("error", "SystemExit: enough"),
    "interrupt": ("error", "KeyboardInterrupt: no reason given"),
    "cancel": ("error", "CancelledError: no reason given"),
    "generate": ("error", "GeneratorExit: no reason given"),
    "fail": ("failed", "not so"),
    "mute": ("error", "Mute: it cannot be shown: RuntimeError"),
    "signalled": ("passed", ""),
    "fault": ("crashed", "its process ended by itself"),
    "closes": ("crashed", "its process ended by itself"),
    "forks": ("passed", ""),
    "silences": ("passed", ""),
    "prints": ("passed", ""),
    "nothing": ("passed", ""),
}


@pytest.mark.conforms("N-37", "N-60")
@pytest.mark.finding("machines 2")
@pytest.mark.finding("machines 6")
def test_each_way_to_end_is_one_row_and_only_what_was_under_way_is_played_again(tmp_path: Path) -> None:
    runs = run_campaign(wild(tmp_path, *ENDS), workers=1)
    assert {str(run.parameters["what"]): (run.verdict, run.reason) for run in runs} == ENDS
    played = Counter((tmp_path / "played").read_text().split())
    assert played == dict.fromkeys(ENDS, 1) | {"fault": 2, "closes": 2}


def test_what_a_run_printed_and_where_it_crashed_belongs_to_its_row(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    runs = run_campaign(wild(tmp_path, "nothing", "prints", "nothing", "fault"), workers=1)
    assert [run.output for run in runs[:3]] == ["", "and here\nhere is the run\n", ""]
    assert "Segmentation fault" in runs[3].trace
    assert "in fault" in runs[3].trace
    assert capfd.readouterr() == ("", "")


def test_a_keeper_that_is_killed_costs_no_run(tmp_path: Path) -> None:
    """Nor does the hanging run that it had outlive it: what that run has locked is free."""
    runs = run_campaign(wild(tmp_path, "nothing", "orphans", "nothing"), workers=1)
    assert [run.verdict for run in runs] == ["passed"] * 3
    with (tmp_path / "held").open() as held:
        fcntl.flock(held, fcntl.LOCK_EX)


def test_a_run_that_kills_its_keeper_each_time_is_one_row(tmp_path: Path) -> None:
    path = wild(tmp_path, "nothing", "orphans", "nothing")
    path.write_text(path.read_text().replace('(FOLDER / "once").touch()', "pass"))
    assert [run.verdict for run in run_campaign(path, workers=1)] == ["passed", "crashed", "passed"]


def test_a_run_that_exits_is_a_row_of_its_repetition_too(tmp_path: Path) -> None:
    run, _ = repeat_run(wild(tmp_path, "leave"), 0)
    assert (run.verdict, run.reason) == ENDS["leave"]


def test_a_file_that_ends_its_workers_is_said_to(tmp_path: Path) -> None:
    path = wild(tmp_path, "nothing")
    path.write_text(
        "import multiprocessing, os\nif multiprocessing.parent_process():\n    os._exit(7)\n"
        + path.read_text()
    )
    seen: list[CampaignRun] = []
    with pytest.raises(HubError, match="status 7 before its first run"):
        run_campaign(path, workers=2, told=seen.append)
    assert seen == []


def test_a_file_that_starts_threads_has_its_players_spawned(tmp_path: Path) -> None:
    """A fork beside a thread may inherit a lock that nobody opens any more."""
    path = wild(tmp_path, "nothing", "fault", "leave", "nothing")
    path.write_text(
        "import threading\nthreading.Thread(target=threading.Event().wait, daemon=True).start()\n"
        + path.read_text()
    )
    runs = run_campaign(path, workers=1)
    assert [run.verdict for run in runs] == ["passed", "crashed", "error", "passed"]
    assert runs[1].output == ""  # a forked one says there where it crashed
