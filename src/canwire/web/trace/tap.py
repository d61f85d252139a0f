"""Receives one line's frames through a channel or a monitor, whose queue is emptied from time to time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire import (
    CanwireError,
    ChannelMode,
    EventKind,
    HubChannel,
    LinePlace,
    LinEventKind,
    LinMonitorMode,
    Monitor,
    Siblings,
)
from canwire.web.trace.store.lin import rows_of_lin

if TYPE_CHECKING:
    import numpy

    from canwire import Hub

QUEUE = 65_536  # records: some seconds of the busiest bus
LIN_QUEUE = 4096  # many seconds of any LIN bus
_EVENTS = (EventKind.ERROR, EventKind.STATE, EventKind.ARBITRATION_LOST, EventKind.OVERRUN)
_LIN_EVENTS = (LinEventKind.ERROR, LinEventKind.STATE, LinEventKind.WAKEUP, LinEventKind.SLEEP)


class Tap:
    """All frames that one line receives and sends, from now until `close`; `over` is True if the board or hub is lost.

    `lost` counts records lost because the queue was full, as of the last request to the hub.
    """

    def __init__(self, hub: Hub, place: LinePlace, number: int) -> None:
        self.place = place
        self.number = number
        self.lost = 0
        self.over = False
        self._queue: _Queue = (_CanQueue if place.info.lin is None else _LinQueue)(hub, place)

    def take(self) -> numpy.ndarray | None:
        """Return the received records; None if there are none."""
        try:
            records = self._queue.take()
        except CanwireError:  # unplugged, or the hub is gone
            self.over = True
            return None
        return records if len(records) else None

    def newly_lost(self) -> int:
        """Ask the hub for the number of records lost since the last call; raises Unplugged, HubLost."""
        before, self.lost = self.lost, self._queue.held.status().lost
        return self.lost - before

    def close(self) -> None:
        """Close the channel or monitor; a second call does nothing."""
        self._queue.held.close()


class _CanQueue:
    """The queue of a CAN line: a channel."""

    def __init__(self, hub: Hub, place: LinePlace) -> None:
        self.held: HubChannel = hub.open_channel(place.board.id, place.line)
        mode = ChannelMode(
            receive=QUEUE, transmit=0, siblings=Siblings.EVERY, events=tuple(map(int, _EVENTS))
        )
        _begin(self.held, lambda: self.held.set_up(mode))

    def take(self) -> numpy.ndarray:
        """Return the received records; raises CanwireError once the line or the hub is lost."""
        return self.held.receive_array()


class _LinQueue:
    """The queue of a LIN line: a monitor."""

    def __init__(self, hub: Hub, place: LinePlace) -> None:
        self.held: Monitor = hub.open_monitor(place.board.id, place.line)
        mode = LinMonitorMode(receive=LIN_QUEUE, events=tuple(map(int, _LIN_EVENTS)))
        _begin(self.held, lambda: self.held.set_up(mode))

    def take(self) -> numpy.ndarray:
        """Return the received records as rows; raises CanwireError once the line or the hub is lost."""
        end = self.held.reading
        if not end.ring.fill():
            self.held.check()
        records = end.ring.take_array(end.ring.capacity)
        end.touched()
        return rows_of_lin(records)


_Queue = _CanQueue | _LinQueue


def _begin(held: HubChannel | Monitor, set_up: Callable[[], object]) -> None:
    try:
        set_up()
        held.activate()
    except CanwireError:
        held.close()
        raise
