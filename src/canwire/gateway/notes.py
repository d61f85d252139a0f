"""What gateways leave at hubs for each other: their own ways, and at each of its two hubs what is known at the other.

So word of a way goes from hub to hub, as far as gateways lead, one step with each look that a gateway takes. A way that
is gone is forgotten as one that is too far: hops count up to a limit (as in RIP, RFC 2453 3.6 on infinity).
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
_AT_ONCE = 6  # ways in a note, which has 1024 bytes
Known = dict[Way, int]
"""Ways, and over how many hubs word of them came."""


def identity(hub: Hub, fresh: str) -> str:
    """What this hub is called among gateways, by whichever address it is reached; `fresh` if it has no name yet.

    Of several that name it at the same time the first one does: a hub keeps notes in their order.
    """
    names = hub.notes(_IDENTITY)
    if not names:
        hub.set_note(_IDENTITY + fresh, b"1")
        names = hub.notes(_IDENTITY)
    return next(iter(names)).removeprefix(_IDENTITY)


def leave_ways(hub: Hub, ways: list[Way]) -> None:
    """A gateway's own; they go with its program."""
    rows = [[way.source, way.target, way.since] for way in ways]
    hub.set_note(ways[0].gateway, json.dumps(rows).encode(), leaves=True)


def known_at(hub: Hub, besides: str = "") -> Known:
    """All ways known there, but for what the gateway `besides` has told.

    Raises BadValue for a note that no gateway wrote.
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
    """Tell there what is known at this gateway's other hub; `notes` were written before. Returns how many are now."""
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
