"""Frames that the hub sends on time by a line's cyclic list, even while this process is busy.

A line has one list of 16 entries, which one program holds. If it is in use, or an interval is no multiple of its ticks,
the timers of the broadcast manager send.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire import CanwireError
from canwire.socketcan.wire import records_to_send

if TYPE_CHECKING:
    import numpy

    from canwire import Hub, LinePlace, Scheduler

    Array = numpy.ndarray


class CyclicFrame:
    """A frame on the list; after `stop` its methods have no effect."""

    def __init__(self, owner: CyclicFrames, index: int) -> None:
        self._owner = owner
        self._index: int | None = index

    def replace(self, row: Array) -> bool:
        """Send this row of `sent_dtype` from now on, at the same times; False if that is impossible."""
        return self._index is not None and self._owner.replace(self._index, row)

    def stop(self) -> None:
        index, self._index = self._index, None
        if index is not None:
            self._owner.remove(index)


class CyclicFrames:
    """The cyclic list of a line, held while a frame is on it."""

    def __init__(self, hub: Hub, place: LinePlace) -> None:
        self._hub = hub
        self._place = place
        self._lease: Scheduler | None = None
        self._used: set[int] = set()

    def start(self, row: Array, interval_s: float) -> CyclicFrame | None:
        """Send a row every `interval_s` seconds, first after one interval; None if the list cannot do it."""
        ticks = self._place.info.capabilities.cyclic
        interval_ns = round(interval_s * 1e9)
        if not ticks.tick_ns or interval_ns % ticks.tick_ns:
            return None
        cycle = interval_ns // ticks.tick_ns
        if not 1 <= cycle <= ticks.maximum:
            return None
        try:
            if self._lease is None or self._lease.over:
                self._lease = self._hub.open_scheduler(self._place.board.id, self._place.line)
                self._used.clear()
                self._lease.resume()
            index = self._lease.add(records_to_send(row).tobytes(), cycle)
            self._used.add(index)
            self._lease.start(index)
        except CanwireError:  # as it is now; a line that is gone its port tells of
            self._let_go_if_unused()
            return None
        return CyclicFrame(self, index)

    def replace(self, index: int, row: Array) -> bool:
        if self._lease is None or self._lease.over or index not in self._used:
            return False
        try:
            self._lease.replace(index, records_to_send(row).tobytes())
        except CanwireError:
            return False
        return True

    def remove(self, index: int) -> None:
        if self._lease is None or index not in self._used:
            return
        self._used.discard(index)
        if not self._lease.over:
            self._lease.remove(index)
        self._let_go_if_unused()

    def _let_go_if_unused(self) -> None:
        """So that other programs can have it."""
        if self._lease is not None and not self._used:
            self._lease.close()
            self._lease = None
