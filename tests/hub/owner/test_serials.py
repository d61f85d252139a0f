"""Hardware ids: the lowest number that nobody has, found without looking at every board."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue
from canwire.hub.owner.serials import Serials
from tests.effort import examples

NAMES = st.sampled_from(
    ["HW000001", "HW000002", "HW000003", "HW000005", "HW3", "HW", "HW-2:b", "dongle", "HW0x1"]
)
STEPS = st.lists(
    st.tuples(st.sampled_from(["number", "name", "pull"]), NAMES, st.integers(0, 99)), max_size=40
)


class Counted(set[str]):
    """Notes how often it was looked into."""

    looks = 0

    def __contains__(self, serial: object) -> bool:
        self.looks += 1
        return super().__contains__(serial)


def lowest(taken: set[str]) -> str:
    return next(name for number in range(1, 99) if (name := f"HW{number:06}") not in taken)


@examples(100)
@given(st.sets(NAMES, max_size=3), STEPS)
def test_boards_that_come_and_go(reserved: set[str], steps: list[tuple[str, str, int]]) -> None:
    serials, there = Serials(reserved), set[str]()
    for what, name, which in steps:
        if what == "pull":
            if there:
                gone = sorted(there)[which % len(there)]
                serials.give_back(gone)
                there.discard(gone)
            continue
        if what == "number":
            assert serials.free() == lowest(there | reserved)
        if what == "name" and name in there:
            with pytest.raises(BadValue, match=f"a board {name} is plugged in already"):
                serials.check(name)
            continue
        taken = serials.free() if what == "number" else serials.check(name)
        serials.take(taken)
        there.add(taken)
    assert all(name in serials for name in there)


def test_a_board_more_is_one_look_more() -> None:
    serials = Serials([])
    serials._taken = counted = Counted()
    for number in range(1, 1001):
        assert serials.free() == f"HW{number:06}"
        serials.take(f"HW{number:06}")
    assert counted.looks <= 2000
