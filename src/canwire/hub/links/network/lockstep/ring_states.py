"""The states of the rings of a program in lockstep at its call, and of the hub's at its answer. No I/O.

On the hub's machine, shared memory contains the records taken and the change that a program waits for. From another
machine both are sent with each call, so that they count from the same moment of the hub's time on any network.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from canwire.hub.links.network.calls import Positions, States
from canwire.hub.links.network.incoming import Incoming
from canwire.hub.links.network.mirrors import Outgoing
from canwire.hub.links.network.wire import Report


def left(mirrors: Iterable[object]) -> States:
    """The program's rings: number, records read (0 for a ring that it writes), position it waits for (0: none)."""
    return tuple(
        (one.number, one.taken if isinstance(one, Incoming) else 0, one.wanted)
        for one in mirrors
        if isinstance(one, Incoming | Outgoing)
    )


def found(states: States, mirror: Callable[[int], object]) -> bool:
    """Set the hub's rings to the states of the program's copies; True if its wait is over. Raises BadMessage."""
    here = False
    for number, taken, wanted in states:
        one = mirror(number)
        if isinstance(one, Outgoing):
            here |= one.want(taken, wanted)
        elif isinstance(one, Incoming):
            here |= one.want(wanted)
    return here


def taken(mirrors: Iterable[object]) -> Positions:
    """The positions up to which the hub has read the program's rings."""
    return tuple((one.number, one.taken) for one in mirrors if isinstance(one, Incoming))


def acknowledged(positions: Positions, mirror: Callable[[int], object]) -> None:
    """Free the room in the program's rings that the hub has read; raises BadMessage."""
    for number, count in positions:
        one = mirror(number)
        if isinstance(one, Outgoing):
            one.acknowledge(Report(number, count, count, False))
