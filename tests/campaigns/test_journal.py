"""What a campaign has done is kept whatever ends it, and the same command plays only what is missing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from canwire import BadValue, CampaignRun, run_campaign
from canwire.campaigns.journal import Journal, journal_of
from canwire.campaigns.loading import Script
from tests.campaigns.scripts import written

pytestmark = pytest.mark.usefixtures("warm_workers")

STEPS = '''
"""Each run leaves its number; run 6 waits where a file says so."""
import time
from pathlib import Path
from canwire import campaign

FOLDER = Path(__file__).parent


@campaign(number=range(9), name=["\\u00e4", "b\\n"])
def steps(lab, number, name):
    with open(FOLDER / "played", "a") as file:
        file.write(f"{number}{name[0]} ")
    if number == 6:
        print("waiting")
        while (FOLDER / "wait").exists():
            time.sleep(0.005)
    if number == 1:
        raise KeyError(name)
    return {"third": number / 3, "text": name, "whole": number, "even": number % 2 == 0, "far": float("inf")}
'''


PROGRAM = """
import canwire

if __name__ == "__main__":
    canwire.run_campaign({steps!r}, workers=1, results={table!r}, told=lambda run: print(run.number, flush=True))
"""


@pytest.fixture
def steps(tmp_path: Path) -> Path:
    return written(tmp_path, "steps.py", STEPS)


@pytest.mark.conforms("N-37")
def test_a_killed_campaign_is_resumed_by_the_same_command(steps: Path, tmp_path: Path) -> None:
    """Run 12 is the first one of number 6: all before it are kept, though the program was killed in it."""
    whole = run_campaign(steps, workers=1, results=tmp_path / "whole.csv")
    (tmp_path / "played").unlink()
    (tmp_path / "wait").touch()
    table = tmp_path / "steps.csv"
    program = PROGRAM.format(steps=str(steps), table=str(table))
    script = written(tmp_path, "program.py", program)
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True) as killed:
        assert killed.stdout is not None
        for line in killed.stdout:  # its keeper has it too: at its end, nothing is played any more
            if line == "11\n":
                os.kill(killed.pid, signal.SIGKILL)
    assert not table.exists()
    (tmp_path / "wait").unlink()
    told: list[CampaignRun] = []
    assert run_campaign(steps, workers=1, results=table, told=told.append) == whole
    assert [run.number for run in told] == list(range(12, 18))
    assert table.read_bytes() == (tmp_path / "whole.csv").read_bytes()
    assert not journal_of(table).exists()
    played = Counter((tmp_path / "played").read_text().split())
    assert set(played) == {f"{number}{name}" for number in range(9) for name in "\u00e4b"}
    assert [one for one, count in played.items() if count > 1] in ([], ["6\u00e4"])  # the one under way


def test_the_journal_gives_back_what_it_was_given(steps: Path, tmp_path: Path) -> None:
    runs = run_campaign(steps, workers=1)
    journal = Journal(tmp_path / "j", Script.read(steps), "steps", 1)
    journal.write(runs)
    journal.close(over=False)
    read = Journal(tmp_path / "j", Script.read(steps), "steps", 1)
    assert list(read.runs.values()) == runs
    assert [(run.trace, run.output, run.wall_s) for run in read.runs.values()] == [
        (run.trace, run.output, run.wall_s) for run in runs
    ]
    read.close(over=True)
    assert not (tmp_path / "j").exists()


def test_a_line_that_was_cut_off_is_played_again(steps: Path, tmp_path: Path) -> None:
    runs = run_campaign(steps, workers=1)
    journal = Journal(tmp_path / "j", Script.read(steps), "steps", 1)
    journal.write(runs[:3])
    journal.close(over=False)
    path = tmp_path / "j"
    path.write_bytes(path.read_bytes()[:-9])
    for known in (2, 3):
        continued = Journal(path, Script.read(steps), "steps", 1)
        assert len(continued.runs) == known
        continued.write(runs[2:3])
        continued.close(over=False)


@pytest.mark.parametrize(
    ("text", "seed", "said"),
    [
        (STEPS + "\n", 1, "with another script: remove it"),
        (STEPS, 2, "with another seed: remove it"),
    ],
)
def test_runs_of_another_campaign_are_not_mixed_in_nor_lost(
    steps: Path, tmp_path: Path, text: str, seed: int, said: str
) -> None:
    table = tmp_path / "t.csv"
    journal = Journal(journal_of(table), Script.read(steps), "steps", 1)
    journal.close(over=False)
    before = journal.path.read_bytes()
    steps.write_text(text)
    with pytest.raises(BadValue, match=said):
        run_campaign(steps, seed=seed, results=table)
    assert journal.path.read_bytes() == before


@pytest.mark.parametrize("text", ["[1]\n", "nothing\n", '{"a": 1}\n'])
def test_a_file_that_is_no_journal_stays(steps: Path, tmp_path: Path, text: str) -> None:
    table = tmp_path / "t.csv"
    journal_of(table).write_text(text)
    with pytest.raises(BadValue, match="not a journal of a campaign"):
        run_campaign(steps, results=table)
    assert journal_of(table).read_text() == text


def test_fewer_runs_are_taken_from_it_and_it_stays(steps: Path, tmp_path: Path) -> None:
    table = tmp_path / "t.csv"

    def stop(run: CampaignRun) -> None:
        if run.number == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_campaign(steps, workers=1, results=table, told=stop)
    told: list[CampaignRun] = []
    assert len(run_campaign(steps, runs=2, workers=1, results=table, told=told.append)) == 2
    assert told == []
    assert len(run_campaign(steps, workers=1, results=table, told=told.append)) == 18
    assert [run.number for run in told] == list(range(4, 18))


def test_two_programs_do_not_write_one_journal(steps: Path, tmp_path: Path) -> None:
    pytest.importorskip("fcntl")
    table = tmp_path / "t.csv"
    first = Journal(journal_of(table), Script.read(steps), "steps", 1)
    with pytest.raises(BadValue, match="another program plays a campaign with these results"):
        run_campaign(steps, workers=1, results=table)
    first.close(over=False)
    assert len(run_campaign(steps, runs=1, workers=1, results=table)) == 1
