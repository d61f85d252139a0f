"""docs/time.md as it stands: five programs of five interfaces, in lockstep, are the same every time."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.lockstep.programs import bench, five_programs, page_serves

pytest.importorskip("can")
RUNS = int(os.environ.get("CANWIRE_LOCKSTEP_RUNS", "2"))


def heard(home: Path, seed: str) -> str:
    with bench(home, *page_serves()) as made:
        return made.run(five_programs(), seed)["log"]


def test_the_same_log_every_time(tmp_path: Path) -> None:
    first = heard(tmp_path / "1", "1")
    assert {line.split()[1].partition("#")[0] for line in first.splitlines()} >= {
        "101", "102", "103", "111", "112", "120", "7DF"
    }  # fmt: skip
    for number in range(2, RUNS + 1):
        assert heard(tmp_path / str(number), "1") == first


def test_another_seed_another_log(tmp_path: Path) -> None:
    assert heard(tmp_path / "1", "1") != heard(tmp_path / "2", "2")
