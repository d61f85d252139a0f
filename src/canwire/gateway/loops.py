"""Finds rings of gateways, of any length, in which frames would circulate without end.

A path is a ring if it returns to its first bus without using the same gateway twice in a row, because no gateway
passes on frames that it has sent itself. A gateway that closes a ring of older ones is refused. If several start at
the same time, the youngest one ends; all gateways agree which one that is.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import NamedTuple


class Way(NamedTuple):
    """One direction of a gateway: from one bus to another, since the gateway was made (`since`, ns of the wall clock).

    The name of a bus contains the identity of its hub: "5f3a/can0".
    """

    gateway: str
    source: str
    target: str
    since: int = 0

    @property
    def age(self) -> tuple[int, str]:
        """A sort key: smaller is older; no two gateways have the same."""
        return self.since, self.gateway


def closed_by(own: list[Way], others: Iterable[Way]) -> list[str] | None:
    """Return the buses of the ring that a gateway closes with older ones, the first repeated at the end, or None."""
    return circle(own, {way for way in others if way.age < own[0].age})


def circle(own: list[Way], others: set[Way]) -> list[str] | None:
    """Return the buses of a ring, with the first one repeated at the end; None if the gateways form no ring."""
    every = {*own, *others}
    for begin in own:
        reached = {(begin.target, begin.gateway): [begin.source, begin.target]}
        waiting = deque(reached)
        while waiting:
            place = waiting.popleft()
            for way in every:
                if way.source != place[0] or way.gateway == place[1]:
                    continue
                path = [*reached[place], way.target]
                if way.target == begin.source and way.gateway != begin.gateway:
                    return path
                if (way.target, way.gateway) not in reached:
                    reached[way.target, way.gateway] = path
                    waiting.append((way.target, way.gateway))
    return None
