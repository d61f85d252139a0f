"""One line listened to: a channel whose records go to the history, a batch at a time."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from canwire import CanwireError, ChannelMode, EventKind, LinePlace, Siblings
from canwire.web.trace.history import LOST, History

if TYPE_CHECKING:
    from canwire import Hub

QUEUE = 65_536  # records: some seconds of the busiest bus
PAUSE_S = 0.02  # between two batches: each wakes this process and takes the hub a signal
_EVENTS = (EventKind.ERROR, EventKind.STATE, EventKind.ARBITRATION_LOST, EventKind.OVERRUN)


class Tap:
    """Everything that one line hears and sends, from now until `close` or until its board or hub is gone."""

    def __init__(self, hub: Hub, place: LinePlace, history: History, index: int) -> None:
        self.place = place
        self._history = history
        self._index = index
        self._lost = 0
        self._closing = threading.Event()
        self._channel = hub.open_channel(place.board.id, place.line)
        try:
            self._channel.set_up(
                ChannelMode(
                    receive=QUEUE, transmit=0, siblings=Siblings.EVERY, events=tuple(map(int, _EVENTS))
                )
            )
            self._channel.activate()
        except CanwireError:
            self._channel.close()
            raise
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
        lost = self._channel.status().lost
        if lost > self._lost:
            self._history.mark(LOST, self._index, lost - self._lost)
            self._lost = lost

    def close(self) -> None:
        """No more rows; a second time does nothing."""
        self._closing.set()
        self._channel.close()
        self._thread.join()

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                records = self._channel.receive_array(None, timeout=None)
            except CanwireError:  # closed, unplugged, or the hub is gone
                return
            if len(records):
                self._history.append(records, self._index)
            self._closing.wait(PAUSE_S)
