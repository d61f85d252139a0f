"""Campaigns on processes of this machine: alike whatever the workers, repeated by number, whole after a crash."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from canwire import BadValue, CampaignRun, repeat_run, run_campaign
from canwire.campaigns.batches import Rules
from canwire.campaigns.loading import Script
from canwire.campaigns.workers import in_processes
from tests.campaigns.scripts import ENDS, FLIPS, LASTS, written

WARM = pytest.mark.usefixtures("warm_workers")  # cold ones play in the first test


@pytest.fixture
def flips(tmp_path: Path) -> Path:
    return written(tmp_path, "flips.py", FLIPS)


@pytest.mark.smoke
@pytest.mark.conforms("N-37")
def test_workers_change_nothing_and_a_number_is_enough_to_repeat(flips: Path) -> None:
    told: list[CampaignRun] = []
    alone = run_campaign(flips, runs=24, seed=3, workers=1, told=told.append)
    assert [run.number for run in alone] == list(range(24))
    assert sorted(told, key=lambda run: run.number) == alone
    assert {run.verdict for run in alone} == {"passed", "failed"}
    assert run_campaign(flips, runs=24, seed=3, workers=2) == alone
    failed = next(run for run in alone if not run.passed)
    assert failed.reason.endswith("errors")
    assert failed.error_frames >= 3
    again, log = repeat_run(flips, failed.number, seed=3)
    assert again == failed
    assert "AssertionError" in again.trace
    assert repeat_run(flips, failed.number, seed=3)[1] == log
    assert len(log) == failed.frames == 20
    other, other_log = repeat_run(flips, failed.number, seed=4)
    assert other.digest != again.digest
    assert other_log != log


@WARM
def test_without_a_number_the_grid_is_gone_through_once_and_stands_in_parquet(
    flips: Path, tmp_path: Path
) -> None:
    pyarrow = pytest.importorskip("pyarrow.parquet")
    runs = run_campaign(flips, workers=1, results=tmp_path / "flips.parquet")
    assert len(runs) == 12
    assert {(run.parameters["bit_rate"], run.parameters["bit"]) for run in runs} == {
        (rate, bit) for rate in (250_000, 500_000) for bit in range(20, 26)
    }
    table = pyarrow.read_table(tmp_path / "flips.parquet")
    assert table.num_rows == 12
    assert table.column_names == [
        "run", "seed", "bit_rate", "bit", "noise", "verdict", "reason", "errors", "seconds", "frames",
        "error_frames", "bus_time_ns", "digest",
    ]  # fmt: skip
    assert table["digest"].to_pylist() == [run.digest for run in runs]
    assert table["errors"].to_pylist() == [run.figures.get("errors") for run in runs]
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.conforms("N-37")
@WARM
def test_a_run_that_takes_its_process_down_is_named_and_the_others_are_played(tmp_path: Path) -> None:
    runs = run_campaign(written(tmp_path, "ends.py", ENDS), workers=2, results=tmp_path / "ends.csv")
    verdicts = {run.number: run.verdict for run in runs}
    assert verdicts == dict.fromkeys(range(12), "passed") | {5: "crashed", 7: "error"}
    assert runs[5].reason == "its process ended by itself"
    assert runs[7].reason == "KeyError: 'seven'"
    assert [run.figures for run in runs if run.passed] == [
        {"square": number * number} for number in range(12) if number not in (5, 7)
    ]
    with (tmp_path / "ends.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["verdict"] for row in rows].count("passed") == 10
    assert rows[3]["square"] == "9"
    assert rows[5]["square"] == ""


@pytest.mark.conforms("N-37")
@WARM
def test_a_run_that_takes_too_long_is_ended_and_the_others_are_played(tmp_path: Path) -> None:
    lasts = written(tmp_path, "lasts.py", LASTS.replace("number == 4", "number > 5"))
    runs = run_campaign(lasts, workers=1, time_limit=0.3)
    verdicts = {run.number: run.verdict for run in runs}
    assert verdicts == dict.fromkeys(range(6), "passed") | {2: "timeout"}
    again, _ = repeat_run(lasts, 2, time_limit=0.1)
    assert (again.verdict, again.reason) == ("timeout", "longer than 0.1 s")
    assert "in for_ever" in again.trace


@pytest.mark.conforms("N-37")
@WARM
def test_a_run_that_nothing_else_ends_takes_its_process_with_it(tmp_path: Path) -> None:
    script = Script.read(written(tmp_path, "lasts.py", LASTS))
    batches = in_processes(script, range(6), Rules(seed=1, limit_s=0.3, grace_s=0.2), 2)
    runs = sorted((run for batch in batches for run in batch), key=lambda run: run.number)
    verdicts = {run.number: run.verdict for run in runs}
    assert verdicts == dict.fromkeys(range(6), "passed") | {2: "timeout", 4: "timeout"}
    assert runs[2].reason == runs[4].reason == "longer than 0.3 s"
    assert [run.figures.get("square") for run in runs] == [0, 1, None, 9, None, 25]


@WARM
def test_a_limit_changes_nothing_for_runs_that_keep_it(flips: Path) -> None:
    assert run_campaign(flips, workers=1, time_limit=3600) == run_campaign(flips, workers=1)


@WARM
def test_what_was_done_is_written_when_it_is_interrupted(flips: Path, tmp_path: Path) -> None:
    seen: list[CampaignRun] = []

    def interrupt(run: CampaignRun) -> None:
        seen.append(run)
        if len(seen) == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_campaign(flips, workers=1, results=tmp_path / "part.csv", told=interrupt)
    with (tmp_path / "part.csv").open(newline="") as file:
        assert len(list(csv.DictReader(file))) == 5


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x = 1\n", "it has none; a campaign is a function under @campaign"),
        ("def broken(:\n", r"line 1: "),
        (FLIPS + FLIPS.replace("flips", "others"), "several campaigns, say which: it has flips, others"),
    ],
)
def test_files_without_a_campaign(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(BadValue, match=said):
        run_campaign(written(tmp_path, "some.py", text))


def test_numbers_out_of_range(flips: Path, tmp_path: Path) -> None:
    for wrong in ({"runs": 0}, {"workers": 1 << 20}, {"seed": -1}):
        with pytest.raises(BadValue):
            run_campaign(flips, **wrong)  # type: ignore[arg-type]
    with pytest.raises(BadValue, match=r"time limit 0: 0\.001 to"):
        run_campaign(flips, time_limit=0)
    with pytest.raises(BadValue, match=r"ends in \.parquet or \.csv"):
        run_campaign(flips, results=tmp_path / "x.txt")
    with pytest.raises(FileNotFoundError):
        run_campaign(flips, results=tmp_path / "nowhere" / "x.csv")
    with pytest.raises(BadValue, match="such as dask://"):
        run_campaign(flips, cluster="host:8786")


def test_a_campaign_that_cannot_begin_leaves_the_table_of_the_last_one(flips: Path, tmp_path: Path) -> None:
    table = written(tmp_path, "flips.csv", "run\n1\n")
    with pytest.raises(BadValue, match="such as dask://"):
        run_campaign(flips, cluster="host:8786", results=table)
    assert table.read_text() == "run\n1\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["flips.csv", "flips.py"]


def test_a_figure_must_not_hide_a_column(tmp_path: Path) -> None:
    text = "from canwire import campaign\n@campaign(bit=[1])\ndef some(lab, bit):\n    return {'bit': 2}\n"
    run, _ = repeat_run(written(tmp_path, "some.py", text), 0)
    assert run.verdict == "error"
    assert "figure 'bit'" in run.reason
