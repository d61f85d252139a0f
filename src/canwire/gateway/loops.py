"""Gateways that would send each other's frames round and round are found, whatever the length of the ring.

A way leads in a circle if it comes back to where it began without using one gateway twice in a row: no gateway hears
what it has sent itself. Who closes a circle of older gateways is refused; so of any that start at the same time the
youngest gives way, and all agree on which one that is.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import NamedTuple


class Way(NamedTuple):
    """From one bus to another, by a gateway that began `since` (ns of the wall clock).

    A bus is named with its hub's identity: "5f3a/can0".
    """

    gateway: str
    source: str
    target: str
    since: int = 0

    @property
    def age(self) -> tuple[int, str]:
        """What is smaller is older; no two gateways are equal."""
        return self.since, self.gateway


def closed_by(own: list[Way], others: Iterable[Way]) -> list[str] | None:
    """The circle that a gateway closes together with older ones: buses, the first one again at the end."""
    return circle(own, {way for way in others if way.age < own[0].age})


def circle(own: list[Way], others: set[Way]) -> list[str] | None:
    """Buses that a frame would go round, the first one again at the end; None where there is no circle."""
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
