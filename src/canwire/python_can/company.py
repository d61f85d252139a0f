"""Warnings in the log when no other node is on the bus, since the program would otherwise wait without a reason."""

from __future__ import annotations

import logging

from canwire import BusEvent, ErrorKind, ErrorState, Hub, LinePlace, LineStatus, conflicts_on, format_rates

_LOG = logging.getLogger("can.canwire")
_TROUBLED = (ErrorState.ERROR_WARNING, ErrorState.ERROR_PASSIVE)


class Company:
    """The warnings of one bus object, each given once. `channel_info` is the text that python-can shows for it."""

    _told_of_private_hub = False

    def __init__(self, hub: Hub, place: LinePlace, channel: str) -> None:
        self._hub = hub
        self._place = place
        self._told = False
        where = "" if hub.address else ", hub in this process"
        self.channel_info = f"canwire {channel}: {place.address} on {place.info.bus or 'no bus'}{where}"

    def tell_of_private_hub(self) -> None:
        """Warn once in a process that the hub is private: other programs cannot be on this bus."""
        if not self._hub.address and not Company._told_of_private_hub:
            Company._told_of_private_hub = True
            _LOG.warning(
                "%s: no hub is running, so no other program can be on this bus; %s", self.channel_info, _START
            )

    def heard_of(self, event: BusEvent) -> None:
        """The controller's state has changed: without acknowledgement, this is the first sign."""
        if event.state in _TROUBLED and not self._told:
            self.look(self._place.status(self._hub))

    def look(self, status: LineStatus) -> None:
        """Warn if no node acknowledges."""
        if self._told or status.last_error != ErrorKind.ACK or status.state == ErrorState.ERROR_ACTIVE:
            return
        self._told = True
        other = (
            f"none runs at {format_rates(status.mode)}"
            if self._hub.address
            else f"no hub is running: {_START}"
        )
        _LOG.warning(
            "%s: no node acknowledges what is sent: a bus needs a second node, on another line, and %s",
            self.channel_info,
            other,
        )

    def gave_up(self, count: int, why: str) -> None:
        """Warn that messages had not been sent when the bus object was shut down."""
        _LOG.warning("%s: shut down with %d messages that did not go out: %s", self.channel_info, count, why)


_START = "start a shared hub with `canwire serve`"


def warn_of_conflicts(hub: Hub, bus: str) -> None:
    """Say in the log which lines of this bus run at different rates: they destroy each other's frames."""
    for conflict in conflicts_on(hub, bus):
        _LOG.warning("%s", conflict)
