"""How a timed program has left its rings when it calls, and how the hub has when it answers. No I/O.

Beside it a program's own memory tells the hub what was taken and which change is waited for. From another machine both
travel with each call, so that they count from the same moment of the hub's time, whatever the network does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from canwire.hub.links.network.calls import Positions, States
from canwire.hub.links.network.incoming import Incoming
from canwire.hub.links.network.mirrors import Outgoing
from canwire.hub.links.network.wire import Report


def left(mirrors: Iterable[object]) -> States:
    """By the program: each ring's number, records taken out (0 where it writes), what it waits for (0: nothing)."""
    return tuple(
        (one.number, one.taken if isinstance(one, Incoming) else 0, one.wanted)
        for one in mirrors
        if isinstance(one, Incoming | Outgoing)
    )


def found(states: States, mirror: Callable[[int], object]) -> bool:
    """The hub's rings are as the program has left its copies; has what it waits for happened? Raises BadMessage."""
    here = False
    for number, taken, wanted in states:
        one = mirror(number)
        if isinstance(one, Outgoing):
            here |= one.want(taken, wanted)
        elif isinstance(one, Incoming):
            here |= one.want(wanted)
    return here


def taken(mirrors: Iterable[object]) -> Positions:
    """What the hub has taken from the program's rings."""
    return tuple((one.number, one.taken) for one in mirrors if isinstance(one, Incoming))


def acknowledged(positions: Positions, mirror: Callable[[int], object]) -> None:
    """The program's rings have room for what the hub has taken; raises BadMessage."""
    for number, count in positions:
        one = mirror(number)
        if isinstance(one, Outgoing):
            one.acknowledge(Report(number, count, count, False))
