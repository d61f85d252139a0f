"""What a serial line of some speed brings, and when."""

from __future__ import annotations

import pytest

from canwire.slcan.pace import Pace


def test_without_a_rate_all_comes_at_once() -> None:
    pace = Pace()
    pace.put(b"t1230\rt")
    assert pace.due(0.0) == b"t1230\rt"
    assert not pace
    assert pace.wait_s(0.0) is None


@pytest.mark.finding("linux 2")
def test_commands_come_one_by_one() -> None:
    pace = Pace(1200)  # six bytes take 50 ms
    pace.put(b"t1230\r" * 4)
    found, at_s = [], 100.0
    while pace:
        found.append((round(at_s, 3), pace.due(at_s)))
        at_s += pace.wait_s(at_s) or 0.0
    assert found == [(at_s, b"t1230\r") for at_s in (100.0, 100.0, 100.05, 100.1)]


@pytest.mark.finding("linux 2")
def test_the_rest_of_a_command_comes_too() -> None:
    pace = Pace(115_200)
    pace.put(b"t12")
    assert pace.due(5.0) == b"t12"
    assert not pace
