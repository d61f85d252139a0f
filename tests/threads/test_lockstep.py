"""Threads of programs in processes of their own, on a hub in lockstep: as in a hub of their own process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("can")

from tests.threads.apart import OPEN, START, played_apart
from tests.threads.shapes import REQUESTS, SHAPES
from tests.threads.test_shapes import in_a_hub

pytestmark = [pytest.mark.conforms("N-61"), pytest.mark.finding("machines 4"), pytest.mark.timeout(120)]
Lockstep = Callable[..., dict[str, str]]


def test_one_program_with_threads_gives_the_log_that_it_gives_alone(canwire_lockstep: Lockstep) -> None:
    program = f"{START}print(*shapes['play']('notified', lambda: {OPEN}), sep='\\n')\n"
    assert canwire_lockstep({"program": program})["program"].splitlines() == in_a_hub("notified")


@pytest.mark.conforms("G-17")
@pytest.mark.parametrize("name", SHAPES)
def test_three_programs_give_the_log_that_their_threads_give_in_one(name: str, tmp_path: Path) -> None:
    *log, _ = in_a_hub(name)
    assert played_apart(tmp_path, name, name) == log


def test_programs_of_different_shapes_give_the_same_log_every_time(tmp_path: Path) -> None:
    first = played_apart(tmp_path / "1", "notified", "cyclic")
    heard = [line.split()[1] for line in first]
    for number in range(REQUESTS):
        assert f"{0x220 + number:X}" in heard
        assert f"{0x330 + number:X}" in heard
    assert heard.count("302") > 20
    assert heard.count("312") > 14
    assert played_apart(tmp_path / "2", "notified", "cyclic") == first
