"""A line of a gateway, used through a channel: the frames it receives, and the results of the frames it sent."""

from __future__ import annotations

import uuid
from contextlib import ExitStack, suppress
from dataclasses import replace
from typing import TYPE_CHECKING

from canwire.boards.can.modes import ChannelMode, ChannelStatus, LineMode, LineStatus, Siblings
from canwire.errors import Closed, HubError
from canwire.gateway.notes import identity
from canwire.gateway.rules import GatewayCounts
from canwire.hub.bring_up import bring_up
from canwire.hub.finding import LinePlace, find_lines, lines_now, unused_lines
from canwire.hub.wanted_mode import WantedMode

if TYPE_CHECKING:
    from canwire.hub.handles.channel import HubChannel
    from canwire.hub.handles.hub import Hub

_QUEUE = 16_384  # frames
_NOTHING = ChannelStatus(False, 0, 0, 0, 0, 0, 0, 0)


class End:
    """One of the two lines of a gateway."""

    channel: HubChannel

    def __init__(self, hub: Hub, line: str | LinePlace) -> None:
        self.hub = hub
        self.place = line if isinstance(line, LinePlace) else _unused(hub, line)
        self.bus = self.place.info.bus or self.place.address
        self.fd = False
        self._lost = 0
        self._status = _NOTHING

    def known_as(self) -> str:
        return f"{identity(self.hub, uuid.uuid4().hex[:8])}/{self.bus}"

    def open(self, closing: ExitStack) -> None:
        """Open a channel on the line, and start it."""
        self.channel = closing.enter_context(self.hub.open_channel(self.place.board.id, self.place.line))
        self.channel.set_up(ChannelMode(receive=_QUEUE, transmit=_QUEUE, siblings=Siblings.OTHERS))
        control = bring_up(self.hub, self.place, self._mode, lambda status: None)
        if control is not None:
            control.close()
        mode = self.channel.activate().mode
        self.fd = mode is not None and mode.long_data

    def newly_lost(self) -> int:
        """Return the number of frames lost since the last call because this program's receive queue was full."""
        lost = self.channel.status().lost
        fresh, self._lost = lost - self._lost, lost
        return fresh

    def account(self, counts: GatewayCounts, *, over: bool = False) -> GatewayCounts:
        """Return `counts` with the results of the frames queued here; with `over`, waiting frames count as discarded.

        Once the channel is gone, the last known state counts.
        """
        with suppress(HubError, Closed):
            if over:
                self.channel.cancel()
            self._status = self.channel.status()
        status = self._status
        given_up = status.aborted + status.refused
        waiting = max(0, counts.passed - status.delivered - given_up)
        return replace(counts, passed=status.delivered, given_up=given_up, waiting=waiting)

    def _mode(self, status: LineStatus) -> LineMode:
        others = [place for place in find_lines(self.hub, self.bus, "CAN") if place != self.place]
        running = [other for _, other in lines_now(self.hub, others)]
        return WantedMode().at_rates_on_bus(running).mode(self.place.info.capabilities)


def _unused(hub: Hub, name: str) -> LinePlace:
    places = find_lines(hub, name, "CAN")
    return next(unused_lines(hub, places), places[0])
