"""The receive queue of one client on a LIN line.

At any moment `accepted` = read + waiting + `lost`.
"""

from __future__ import annotations

from collections.abc import Callable

from canwire.boards.lin.modes import LinMonitorMode, LinMonitorStatus
from canwire.ring import Ring
from canwire.values.lin.event import LinEvent
from canwire.values.lin.frame import LinFrame
from canwire.values.lin.record import OVERRUN, TIME_SIZE, lin_frame_of_record, message_type
from canwire.values.record import RECORD_SIZE

LAST = OVERRUN << 32  # the bit of the second word of the record that fills a queue
_M32 = 0xFFFF_FFFF

Put = Callable[[bytearray, int, int], object]


class LinMonitor:
    """Gets a copy of every message of its line while it is `active`; it sends nothing.

    The ring has records of values/lin/record.py; the record that fills the ring has its overrun bit set.
    The splitter delivers frames by `put`: it adds a record with this time, and LAST if it fills the queue.
    """

    def __init__(self, mode: LinMonitorMode, *, ring: Ring | None = None) -> None:
        self.mode = mode
        self.active = False
        self.ring = Ring(mode.receive, exact=mode.exact) if ring is None else ring
        self.put: Put = self._put_ticks if mode.ticks else self.ring.put_at
        self._origin_ns = self._tick_ns = 0
        self._events = frozenset(mode.events)

    @property
    def accepted(self) -> int:
        """The messages for this monitor so far: those read, those that wait, and those lost."""
        return self.ring.written + self.ring.lost

    @property
    def lost(self) -> int:
        """Messages that came when the queue was full."""
        return self.ring.lost

    def stamp(self, origin_ns: int, tick_ns: int) -> None:
        """Count times from `origin_ns` from now on, in ticks if the mode says so."""
        self._origin_ns, self._tick_ns = origin_ns, tick_ns

    def deliver_event(self, kind: int, record: bytes, stamped: bool) -> None:
        """Deliver an event's record; without `stamped` its time does not change."""
        if kind in self._events:
            put = self.put if stamped else self.ring.put_at
            put(bytearray(record), int.from_bytes(record[:TIME_SIZE], "little"), LAST)

    def _put_ticks(self, record: bytearray, at_ns: int, last: int) -> bool:
        if self._tick_ns:
            at_ns = (at_ns - self._origin_ns) // self._tick_ns & _M32
        return self.ring.put_at(record, at_ns, last)

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
