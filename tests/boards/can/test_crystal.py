"""A wrong clock makes every time of a controller wrong by one factor; afterwards they are right to the picosecond."""

from __future__ import annotations

import pytest

from canwire.boards.can.crystal import Crystal
from tests.boards.can.test_line import Bench

NAMES = ("bit_ps", "sample_ps", "data_bit_ps", "data_sample_ps")


def times(node: object) -> list[int]:
    return [getattr(node, name) for name in NAMES]


def test_one_fault() -> None:
    node = Bench().line.controller
    right, crystal = times(node), Crystal()
    crystal.pull(node, 0.5)
    assert times(node) == [2 * time for time in right]
    crystal.release(node, 0.5)
    assert times(node) == right


def test_faults_multiply_and_end_one_by_one() -> None:
    node = Bench().line.controller
    right, crystal = times(node), Crystal()
    crystal.pull(node, 1.001)
    crystal.pull(node, 0.5)
    assert times(node) == pytest.approx([time / 1.001 / 0.5 for time in right], abs=1)
    crystal.release(node, 1.001)
    assert times(node) == [2 * time for time in right]
    crystal.release(node, 0.5)
    assert times(node) == right


def test_new_bit_times_are_wrong_as_well() -> None:
    node = Bench().line.controller
    right, crystal = times(node), Crystal()
    crystal.pull(node, 0.5)
    for name, time in zip(NAMES, right, strict=True):
        setattr(node, name, time)
    crystal.configured(node)
    assert times(node) == [2 * time for time in right]
    crystal.release(node, 0.5)
    assert times(node) == right
