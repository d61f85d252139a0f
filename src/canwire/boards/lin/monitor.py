"""The receive queue of one client on a LIN line.

At any moment `accepted` = read + waiting + `lost`.
"""

from __future__ import annotations

from collections.abc import Callable

from canwire.boards.can.channel import Channel
from canwire.boards.lin.modes import LinMonitorMode, LinMonitorStatus
from canwire.ring import Ring
from canwire.values.lin.event import LinEvent
from canwire.values.lin.frame import LinFrame
from canwire.values.lin.record import OVERRUN, lin_frame_of_record, message_type
from canwire.values.record import RECORD_SIZE

_FLAGS_AT = 15  # of a record: the byte of its info word that has the overrun bit
_OVERRUN_FLAG = OVERRUN >> 24


Queue = tuple[Callable[[], int], Callable[[bytes], object]]


class LinMonitor:
    """Gets a copy of every message of its line while it is `active`; it sends nothing.

    The ring has records of values/lin/record.py; the record that fills the ring has its overrun bit set.
    `queue` is what the splitter needs for frames: how many more records fit, and the function that adds one.
    """

    def __init__(self, mode: LinMonitorMode, *, ring: Ring | None = None) -> None:
        self.mode = mode
        self.active = False
        self.ring = Ring(mode.receive, exact=mode.exact) if ring is None else ring
        self._channel = Channel(1, 0, rings=(self.ring, None))
        self.queue: Queue = (self.ring.free, self._channel.deliver_event)
        self._events = frozenset(mode.events)

    @property
    def accepted(self) -> int:
        """The messages for this monitor so far: those read, those that wait, and those lost."""
        return int(self._channel.accepted)

    @property
    def lost(self) -> int:
        """Messages that came when the queue was full."""
        return self.ring.lost

    def stamp(self, origin_ns: int, tick_ns: int) -> None:
        """Count times from `origin_ns` from now on, in ticks if the mode says so."""
        self._channel.origin_ns = origin_ns
        self._channel.tick_ns = tick_ns if self.mode.ticks else 0

    def deliver_event(self, kind: int, record: bytes, stamped: bool) -> None:
        """Deliver an event's record; without `stamped` its time does not change."""
        if kind in self._events:
            if self.ring.free() == 1:
                record = marked(record)
            self._channel.deliver_event(record, stamped)

    def take(self) -> LinFrame | LinEvent | None:
        """Remove and return the oldest message; None if there is none."""
        record = self.ring.take_bytes()
        return None if record is None else message_of_record(record)

    def status(self) -> LinMonitorStatus:
        fill = 100 * self.ring.fill() // self.ring.capacity
        return LinMonitorStatus(self.active, self.accepted, self.lost, fill)


def message_of_record(record: bytes) -> LinFrame | LinEvent:
    """The frame or event in a record of a monitor."""
    assert len(record) == RECORD_SIZE
    return LinEvent.from_record(record) if message_type(record) else lin_frame_of_record(record)


def marked(record: bytes) -> bytes:
    """The record with its overrun bit set, for the record that fills a queue."""
    flags = record[_FLAGS_AT] | _OVERRUN_FLAG
    return record[:_FLAGS_AT] + bytes([flags]) + record[_FLAGS_AT + 1 :]
