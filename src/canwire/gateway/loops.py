"""Gateways that would send each other's frames round and round are found before they start.

Each leaves a note at the hubs of its two buses: which ways it goes. A way leads in a circle if it comes back to where
it began without using one gateway twice in a row: no gateway hears what it has sent itself. A circle through four or
more hubs is not seen: each gateway looks at the notes of its own two.
"""

from __future__ import annotations

import json
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from canwire.errors import BadValue
from canwire.values.checks import shown

if TYPE_CHECKING:
    from canwire.hub.handles.hub import Hub

PREFIX = "gateway/"
_IDENTITY = "gateway-hub"


class Way(NamedTuple):
    """From one bus to another, by a gateway. A bus is named with its hub's identity: "5f3a/can0"."""

    gateway: str
    source: str
    target: str


def identity(hub: Hub, fresh: str) -> str:
    """What this hub is called among gateways, by whichever address it is reached; `fresh` if it has no name yet."""
    name = hub.note(_IDENTITY)
    if not name:
        hub.set_note(_IDENTITY, fresh.encode())
        name = hub.note(_IDENTITY)
    return name.decode()


def as_note(ways: list[Way]) -> bytes:
    """A gateway's note."""
    return json.dumps([[way.source, way.target] for way in ways]).encode()


def ways_at(hub: Hub) -> set[Way]:
    """Those of all gateways that have left their note there. Raises BadValue for a note that no gateway wrote."""
    found = set()
    for name, value in hub.notes(PREFIX).items():
        try:
            pairs = json.loads(value)
            found |= {Way(name, str(source), str(target)) for source, target in pairs}
        except (ValueError, TypeError):
            raise BadValue(
                f"note {name} at {hub.address or 'the hub'}: {shown(value)} is no gateway's"
            ) from None
    return found


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
