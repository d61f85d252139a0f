"""A CAN or LIN node of a lab as a source: it is emptied in the time of the lab, soon after new entries."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from canwire.logs.batch import batch_of, in_time, records_of_line
from canwire.logs.entry import LogEntry, LogMark, MarkKind
from canwire.values.event import EventKind
from canwire.values.lin.event import LinEventKind
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

_SOON_NS = 5_000_000  # a saturated bus at 1 Mbit/s brings some 100 frames meanwhile
_EVENTS = (EventKind.ERROR, EventKind.STATE, EventKind.OVERRUN)
_LIN_EVENTS = (LinEventKind.ERROR, LinEventKind.STATE, LinEventKind.SLEEP, LinEventKind.WAKEUP)
_AT_ONCE = 1 << 16


class LabSource:
    """The frames, errors and states that a LabNode receives. `own`: the node was made for it and is removed with it."""

    def __init__(self, node: Any, channel: str, *, own: bool) -> None:
        self.channels = [channel]
        self.address = f"{channel}.{node.name}"
        self._node = node
        self._own = own
        self._waiting = False
        node.events()  # they are kept from now on

    def take(self, timeout_s: float) -> numpy.ndarray:
        """Frames and events by their time; never waits, because only the script lets the time of a lab pass."""
        del timeout_s
        frames = records_of_line(self._node.receive_array(), 0)
        events = self._node.events(*_EVENTS)
        if not events:
            return frames
        entries = [LogEntry(event.timestamp_ns, self.channels[0], event) for event in events]
        both = load_numpy().concatenate([frames, batch_of(entries, self.channels).records])
        return in_time(both)

    def lost(self) -> list[int]:
        return [int(self._node.lost)]

    def marks(self) -> list[LogEntry]:
        settings, now_ns = self._node.settings, self._node.time.now_ns
        data = settings.data_timing.bit_rate if settings.data_timing is not None else 0
        return self._entries(
            LogMark(MarkKind.CLOCK, now_ns, text="lab"),
            LogMark(MarkKind.BIT_RATE, now_ns, bit_rate=settings.timing.bit_rate, data_bit_rate=data),
        )

    def start(self, drain: Callable[[], None]) -> bool:
        time = self._node.time

        def emptied() -> None:
            self._waiting = False
            drain()

        def came() -> None:
            if not self._waiting and not time.closed:
                self._waiting = True
                time.at(time.now_ns + _SOON_NS, emptied, background=True)

        self._node.on_frames(came)
        self._node.on_events(came)
        return True

    def close(self) -> None:
        if not self._node.time.closed:
            self._node.on_frames(None)
            self._node.on_events(None)
            if self._own:
                self._node.close()

    def _entries(self, *marks: LogMark) -> list[LogEntry]:
        return [LogEntry(mark.timestamp_ns, self.channels[0], mark) for mark in marks]


class LabLinSource(LabSource):
    """The frames, errors and states that a LabLinNode receives."""

    def take(self, timeout_s: float) -> numpy.ndarray:
        """Return frames and events by their time; never waits."""
        del timeout_s
        frames = self._node.receive_many(_AT_ONCE)
        entries = [
            LogEntry(frame.timestamp_ns, self.channels[0], frame, "T" if frame.sent else "R")
            for frame in frames
        ]
        events = self._node.events(*_LIN_EVENTS)
        entries += [LogEntry(event.timestamp_ns, self.channels[0], event) for event in events]
        return in_time(batch_of(entries, self.channels).records)

    def marks(self) -> list[LogEntry]:
        now_ns = self._node.time.now_ns
        return self._entries(
            LogMark(MarkKind.CLOCK, now_ns, text="lab"),
            LogMark(MarkKind.BIT_RATE, now_ns, bit_rate=self._node.bus.bit_rate),
        )
