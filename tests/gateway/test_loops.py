"""Circles of gateways: found whatever their length, never where there is none."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from canwire.gateway.loops import Way, circle
from tests.cases import each
from tests.effort import examples


def both(gateway: str, one: str, other: str) -> list[Way]:
    return [Way(gateway, one, other), Way(gateway, other, one)]


@each(
    ("own", "others", "path"),
    [
        (both("a", "1", "2"), [], None),
        (both("a", "1", "2"), both("b", "2", "3"), None),
        (both("a", "1", "2"), both("b", "1", "2"), ["1", "2", "1"]),
        ([Way("a", "1", "2")], [Way("b", "2", "1")], ["1", "2", "1"]),
        ([Way("a", "1", "2")], [Way("b", "1", "2")], None),
        ([Way("a", "3", "1")], [*both("b", "1", "2"), *both("c", "2", "3")], ["3", "1", "2", "3"]),
        ([Way("a", "1", "3")], [Way("b", "1", "2"), Way("c", "2", "3")], None),
        (both("a", "9", "1"), both("b", "1", "2"), None),
    ],
)
def test_circles(own: list[Way], others: list[Way], path: list[str] | None) -> None:
    assert circle(own, set(others)) == path


BUSES = st.sampled_from("1234")


@examples(100)
@given(
    st.lists(
        st.tuples(BUSES, BUSES, st.booleans()).filter(lambda one: one[0] != one[1]), min_size=1, max_size=5
    )
)
def test_agrees_with_passing_frames_on(joined: list[tuple[str, str, bool]]) -> None:
    """A frame is passed on from bus to bus; if it still is after as many steps as there are places, it is for ever."""
    ways = [
        [Way(str(number), one, other)] + [Way(str(number), other, one)] * both_ways
        for number, (one, other, both_ways) in enumerate(joined)
    ]
    every = [way for gateway in ways for way in gateway]
    endless = False
    for begin in ways[-1]:
        under_way = {(begin.target, begin.gateway)}
        for _ in range(len(every) * 5):
            under_way = {
                (way.target, way.gateway)
                for bus, gateway in under_way
                for way in every
                if way.source == bus and way.gateway != gateway
            }
            endless |= (begin.target, begin.gateway) in under_way
    assert (circle(ways[-1], set(every) - set(ways[-1])) is not None) == endless
