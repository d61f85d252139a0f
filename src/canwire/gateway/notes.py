"""The notes that gateways write at hubs for each other: their own ways, and the ways known at their other hub.

So a way becomes known at all hubs that gateways connect, one hub further with each check of a gateway. A way that no
longer exists is dropped like one that is too far away: its hops count up to a limit (as in RIP, RFC 2453 3.6,
infinity).
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from canwire.errors import BadValue
from canwire.gateway.loops import Way
from canwire.values.checks import shown

if TYPE_CHECKING:
    from canwire.hub.handles.hub import Hub

PREFIX = "gateway/"
_FAR = "gateway-far/"
_IDENTITY = "gateway-hub/"
_FARTHEST = 32  # hubs
_AT_ONCE = 6  # ways in a note, which can hold 1024 bytes
Known = dict[Way, int]
"""Ways, and the number of hubs over which they became known."""


def identity(hub: Hub, fresh: str) -> str:
    """Return the name of this hub among gateways, the same for all its addresses; `fresh` if it has none yet.

    If several gateways name it at the same time, the first name counts, because a hub keeps the order of notes.
    """
    names = hub.notes(_IDENTITY)
    if not names:
        hub.set_note(_IDENTITY + fresh, b"1")
        names = hub.notes(_IDENTITY)
    return next(iter(names)).removeprefix(_IDENTITY)


def leave_ways(hub: Hub, ways: list[Way]) -> None:
    """Write the gateway's own ways; the hub removes them when the program ends."""
    rows = [[way.source, way.target, way.since] for way in ways]
    hub.set_note(ways[0].gateway, json.dumps(rows).encode(), leaves=True)


def known_at(hub: Hub, besides: str = "") -> Known:
    """Return all ways known at this hub, except those that the gateway `besides` has passed on.

    Raises BadValue for a note that was not written by a gateway.
    """
    found: Known = {}
    for name, value in hub.notes(PREFIX).items():
        for source, target, since in _rows(hub, name, value, 3):
            found[Way(name, str(source), str(target), int(since))] = 0
    for name, value in hub.notes(_FAR).items():
        if not besides or not name.startswith(_far(besides)):
            for gateway, source, target, since, hops in _rows(hub, name, value, 5):
                way = Way(str(gateway), str(source), str(target), int(since))
                found[way] = min(int(hops), found.get(way, _FARTHEST))
    return found


def pass_on(hub: Hub, gateway: str, known: Known, notes: int) -> int:
    """Write the ways known at this gateway's other hub to `hub`, in place of `notes` earlier notes.

    Returns the number of notes that are now in use.
    """
    rows = sorted(
        [way.gateway, way.source, way.target, way.since, hops + 1]
        for way, hops in known.items()
        if hops + 1 < _FARTHEST and way.gateway != gateway
    )
    parts = [rows[at : at + _AT_ONCE] for at in range(0, len(rows), _AT_ONCE)]
    for number in range(max(notes, len(parts))):
        value = json.dumps(parts[number]).encode() if number < len(parts) else b""
        name = f"{_far(gateway)}{number}"
        if hub.note(name) != value:
            hub.set_note(name, value, leaves=True)
    return len(parts)


def _far(gateway: str) -> str:
    return f"{_FAR}{gateway.removeprefix(PREFIX)}/"


def _rows(hub: Hub, name: str, value: bytes, width: int) -> list[list[Any]]:
    try:
        rows = json.loads(value)
        if all(len(row) == width for row in rows):
            return list(rows)
    except (ValueError, TypeError):
        pass
    raise BadValue(f"note {name} at {hub.address or 'the hub'}: {shown(value)} is no gateway's")
