"""Waiting for a condition: how long each wait for a signal may be."""

from __future__ import annotations

from itertools import count

from canwire.platform.waiting import Waiting
from tests.cases import each


class Signals(Waiting):
    """Signals come whenever somebody waits; `waits` has the timeouts."""

    def __init__(self) -> None:
        self.waits: list[float | None] = []

    def wait(self, timeout: float | None = None) -> bool:
        self.waits.append(timeout)
        return True


@each(
    ("timeout", "recheck", "longest"),
    [(None, None, None), (60, None, 60), (None, 0.5, 0.5), (60, 0.5, 0.5), (0.25, 0.5, 0.25)],
)
def test_between_two_looks_it_waits_for_a_signal(
    timeout: float | None, recheck: float | None, longest: float | None
) -> None:
    signals, looks = Signals(), count()
    assert signals.wait_for(lambda: next(looks) == 3, timeout, recheck)
    assert len(signals.waits) == 3
    for wait in signals.waits:
        assert wait == longest if timeout is None or longest == recheck else 0 < wait <= longest
