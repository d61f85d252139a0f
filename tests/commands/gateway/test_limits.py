"""A gateway's limits are told while it runs, and not with each frame."""

from __future__ import annotations

import pytest

from canwire import GatewayCounts
from canwire.commands.gateway.limits import Limits


@pytest.mark.conforms("N-34")
def test_a_limit_is_told_the_first_time_and_then_once_a_minute() -> None:
    said: list[str] = []
    now_s = 100.0
    limits = Limits("there", said.append, lambda: now_s)
    limits.look(GatewayCounts(heard=5, passed=5))
    assert said == []
    limits.look(GatewayCounts(heard=9, passed=5, limited=3, lost=1))
    assert said == [
        "there: more frames than --rate allows: 3 not passed on so far",
        "there: more frames than the queues hold: 1 lost so far",
    ]
    now_s += 59
    limits.look(GatewayCounts(heard=20, limited=9, lost=1))
    assert len(said) == 2
    now_s += 1
    limits.look(GatewayCounts(heard=20, limited=9, lost=1, unfit=2))
    assert said[2:] == [
        "there: more frames than --rate allows: 9 not passed on so far",
        "there: CAN FD for a line that knows classic CAN only: 2 not passed on so far",
    ]
    now_s += 100
    limits.look(GatewayCounts(heard=20, limited=9, lost=1, unfit=2))
    assert len(said) == 4
