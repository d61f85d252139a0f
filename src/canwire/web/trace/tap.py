"""One line listened to: a channel or a monitor whose records go to the history, a batch at a time."""

from __future__ import annotations

import threading
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
from canwire.web.trace.history import LOST, History
from canwire.web.trace.lin import rows_of_lin

if TYPE_CHECKING:
    import numpy

    from canwire import Hub

QUEUE = 65_536  # records: some seconds of the busiest bus
PAUSE_S = 0.02  # between two batches: each wakes this process and takes the hub a signal
LIN_QUEUE = 4096  # many seconds of any LIN bus
_EVENTS = (EventKind.ERROR, EventKind.STATE, EventKind.ARBITRATION_LOST, EventKind.OVERRUN)
_LIN_EVENTS = (LinEventKind.ERROR, LinEventKind.STATE, LinEventKind.WAKEUP, LinEventKind.SLEEP)


class Tap:
    """Everything that one line hears and sends, from now until `close` or until its board or hub is gone."""

    def __init__(self, hub: Hub, place: LinePlace, history: History, index: int) -> None:
        self.place = place
        self._history = history
        self._index = index
        self._lost = 0
        self._closing = threading.Event()
        self._queue: _Queue = (_CanQueue if place.info.lin is None else _LinQueue)(hub, place)
        self._thread = threading.Thread(target=self._run, name=f"tap on {place.address}")
        self._thread.start()

    @property
    def lost(self) -> int:
        """Records that found the queue full since it was opened."""
        return self._lost

    @property
    def over(self) -> bool:
        """Board or hub are gone."""
        return not self._thread.is_alive()

    def count_lost(self) -> None:
        """Ask the hub, and mark in the history what is missing since the last time; raises Unplugged, HubLost."""
        lost = self._queue.held.status().lost
        if lost > self._lost:
            self._history.mark(LOST, self._index, lost - self._lost)
            self._lost = lost

    def close(self) -> None:
        """No more rows; a second time does nothing."""
        self._closing.set()
        self._queue.held.close()
        self._thread.join()

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                records = self._queue.take()
            except CanwireError:  # closed, unplugged, or the hub is gone
                return
            if len(records):
                self._history.append(records, self._index)
            self._closing.wait(PAUSE_S)


class _CanQueue:
    """Of a CAN line: a channel."""

    def __init__(self, hub: Hub, place: LinePlace) -> None:
        self.held: HubChannel = hub.open_channel(place.board.id, place.line)
        mode = ChannelMode(
            receive=QUEUE, transmit=0, siblings=Siblings.EVERY, events=tuple(map(int, _EVENTS))
        )
        _begin(self.held, lambda: self.held.set_up(mode))

    def take(self) -> numpy.ndarray:
        """What has come, waiting for the first; raises CanwireError once the line or the hub is gone."""
        return self.held.receive_array(None, timeout=None)


class _LinQueue:
    """Of a LIN line: a monitor."""

    def __init__(self, hub: Hub, place: LinePlace) -> None:
        self.held: Monitor = hub.open_monitor(place.board.id, place.line)
        mode = LinMonitorMode(receive=LIN_QUEUE, events=tuple(map(int, _LIN_EVENTS)))
        _begin(self.held, lambda: self.held.set_up(mode))

    def take(self) -> numpy.ndarray:
        """As a channel's."""
        end = self.held.reading
        if not end.ring.fill():
            self.held.check()
            end.wait(None)
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
