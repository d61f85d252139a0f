"""One gateway among others: it publishes its directions, and is refused if it closes a ring."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire.errors import BadValue, Closed, HubError
from canwire.gateway.loops import Way, closed_by
from canwire.gateway.notes import PREFIX, Known, known_at, leave_ways, pass_on

if TYPE_CHECKING:
    from canwire.hub.handles.hub import Hub


class Claim:
    """The notes of a gateway between two buses, each given as a hub and the bus's name with the hub's identity
    ("5f3a/can0"); `there` and `back` are the directions in which frames pass.

    Call `look` regularly: it copies the ways that are known at each hub to the other.
    """

    def __init__(
        self,
        buses: tuple[tuple[Hub, str], tuple[Hub, str]],
        there: bool,
        back: bool,
        wall_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        (first, source), (second, target) = buses
        note, since = PREFIX + uuid.uuid4().hex[:16], wall_ns()
        self._ways = [Way(note, source, target, since)] * there + [Way(note, target, source, since)] * back
        self._hubs = [first] if source.partition("/")[0] == target.partition("/")[0] else [first, second]
        self._notes = [0] * len(self._hubs)

    def stake(self) -> None:
        """Write the notes at the hubs; raises BadValue for a ring."""
        for hub in self._hubs:
            leave_ways(hub, self._ways)
        self.look()

    def look(self) -> None:
        """Pass on the known ways; raises BadValue if this gateway closes a ring of older ones."""
        gateway = self._ways[0].gateway
        known = [known_at(hub, besides=gateway) for hub in self._hubs]
        self._check({way for each in known for way in each if way.gateway != gateway})
        if len(self._hubs) == 2:
            for place, hub in enumerate(self._hubs):
                self._notes[place] = pass_on(hub, gateway, known[1 - place], self._notes[place])

    def give_up(self) -> None:
        """Remove all notes."""
        nothing: Known = {}
        for place, hub in enumerate(self._hubs):
            with suppress(HubError, Closed):  # then the notes are gone with the hub, or with this program
                pass_on(hub, self._ways[0].gateway, nothing, self._notes[place])
                hub.set_note(self._ways[0].gateway, b"")

    def _check(self, others: set[Way]) -> None:
        path = closed_by(self._ways, others)
        if path is not None:
            around = " > ".join(name.partition("/")[2] for name in path)
            raise BadValue(
                f"gateways would pass frames round and round: {around}; another one joins these buses already"
            )
