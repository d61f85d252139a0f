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
    from canwire.socketcan.setting import Setting

    Array = numpy.ndarray


_AGAIN_S = 1.0  # before a list that another program holds is tried again


class CyclicFrame:
    """A frame on the list; after `stop` its methods have no effect."""

    def __init__(self, owner: CyclicFrames, index: int, record: bytes, cycle: int) -> None:
        self._owner = owner
        self.index: int | None = index
        self.record, self.cycle = record, cycle

    def replace(self, row: Array) -> bool:
        """Send this row of `sent_dtype` from now on, at the same times; False if that is impossible."""
        record = records_to_send(row).tobytes()
        if self.index is None or not self._owner.replace(self.index, record):
            return False
        self.record = record
        return True

    def stop(self) -> None:
        index, self.index = self.index, None
        if index is not None:
            self._owner.remove(self, index)


class CyclicFrames:
    """The cyclic list of a line, held while a frame is on it."""

    def __init__(self, hub: Hub, place: LinePlace) -> None:
        self._hub = hub
        self._place = place
        self._lease: Scheduler | None = None
        self._frames: list[CyclicFrame] = []
        self._displaced: list[CyclicFrame] = []  # since the hub was away

    def start(self, row: Array, interval_s: float) -> CyclicFrame | None:
        """Send a row every `interval_s` seconds, first after one interval; None if the list cannot do it."""
        ticks = self._place.info.capabilities.cyclic
        interval_ns = round(interval_s * 1e9)
        if not ticks.tick_ns or interval_ns % ticks.tick_ns:
            return None
        cycle = interval_ns // ticks.tick_ns
        if not 1 <= cycle <= ticks.maximum:
            return None
        record = records_to_send(row).tobytes()
        try:
            index = self._put(record, cycle)
        except CanwireError:  # as it is now; a line that is gone its port tells of
            self._let_go_if_unused()
            return None
        self._frames.append(CyclicFrame(self, index, record, cycle))
        return self._frames[-1]

    def _put(self, record: bytes, cycle: int) -> int:
        if self._lease is None or self._lease.over:
            self._lease = self._hub.open_scheduler(self._place.board.id, self._place.line)
            self._lease.resume()
        index = self._lease.add(record, cycle)
        self._lease.start(index)
        return index

    def move(self, hub: Hub, place: LinePlace, setting: Setting) -> None:
        """Continue on this line, with a hub that is back."""
        self._hub, self._place, self._lease = hub, place, None
        self._displaced = list(self._frames)
        self._settle(setting)

    def _settle(self, setting: Setting, told: str = "") -> None:
        try:
            while self._displaced:
                frame = self._displaced[0]
                frame.index = self._put(frame.record, frame.cycle)
                self._displaced.pop(0)
        except CanwireError as error:
            if self._hub.lost:
                return
            why = str(error)
            if why != told:
                setting.say(f"{self._place.address}: cyclic frames wait: {why}")
            setting.loop.call_in(_AGAIN_S, lambda: self._settle(setting, why))

    def replace(self, index: int, record: bytes) -> bool:
        if self._lease is None or self._lease.over:
            return self._hub.lost  # then it is for the hub's return
        try:
            self._lease.replace(index, record)
        except CanwireError:
            return False
        return True

    def remove(self, frame: CyclicFrame, index: int) -> None:
        self._frames.remove(frame)
        if frame in self._displaced:
            self._displaced.remove(frame)
        elif self._lease is not None and not self._lease.over:
            self._lease.remove(index)
        self._let_go_if_unused()

    def _let_go_if_unused(self) -> None:
        """So that other programs can have it."""
        if self._lease is not None and not self._frames:
            self._lease.close()
            self._lease = None
