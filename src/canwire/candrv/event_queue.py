"""The event queue of a receive channel: its capacity, a mask of event types, and the count of lost events.

This module neither waits nor locks: the handle does. Source: CANDRV manual, 7.6, 7.7, 8.7, 8.9; rulings.md 15.
"""

from __future__ import annotations

import struct
from collections import deque
from typing import NamedTuple

from canwire import BadValue
from canwire.candrv.constants import EVERY_EVENT, MESSAGE_EVENTS, CanbusEvent
from canwire.candrv.structures import CAN_EVENT, CAN_TIME, CAN_TRANSMIT_DATA

DWORD = 0xFFFF_FFFF
_LAYOUT = struct.Struct("<IIIIIIBB8s2xI")
assert _LAYOUT.size == CAN_EVENT.SIZE


class Event(NamedTuple):
    """An event. `event` is a CanbusEvent, `time` the 64-bit CAN time, `lost` the number of events lost before it.

    The other fields apply only to messages received, transmitted and aborted: `fmt` is FrameFormat.STD or EXT,
    `identifier` is aligned by the device's entry Align, `data` holds the frame's bytes (none in remote frames).
    """

    event: int
    time: int = 0
    lost: int = 0
    fmt: int = 0
    identifier: int = 0
    rtr: int = 0
    dlc: int = 0
    data: bytes = b""

    @property
    def type(self) -> CanbusEvent:
        """`event` as a CanbusEvent."""
        return CanbusEvent(self.event)

    @property
    def has_message(self) -> bool:
        """Whether it carries a message."""
        return bool(self.event & MESSAGE_EVENTS)

    def pack(self) -> bytes:
        """The bytes of a CAN_EVENT, the same as those of CAN_EVENT.pack(), but faster."""
        event, time, lost, fmt, identifier, rtr, dlc, data = self
        return _LAYOUT.pack(event, time & DWORD, time >> 32, lost, fmt, identifier, rtr, dlc, data, 0)

    def to_structure(self) -> CAN_EVENT:
        """The event as a structure with the manual's fields."""
        data = CAN_TRANSMIT_DATA(self.fmt, self.identifier, self.rtr, self.dlc, self.data)
        return CAN_EVENT(self.event, CAN_TIME(self.time & DWORD, self.time >> 32), self.lost, data)

    @classmethod
    def from_structure(cls, of: CAN_EVENT) -> Event:
        """The event in a structure."""
        message, time = of.data, of.time.high << 32 | of.time.low
        if not of.event & MESSAGE_EVENTS:
            return cls(of.event, time, of.lost)
        data = b"" if message.rtr else bytes(message.msg[: message.dlc])
        return cls(of.event, time, of.lost, message.fmt, message.identifier, message.rtr, message.dlc, data)


class EventQueue:
    """Up to `capacity` events of the types in `mask`; the oldest is read first.

    An event whose type is not in the mask is ignored and not counted. An event is lost if the queue is full, or if a
    new mask excludes its type while it waits: the next event in the queue then contains the number of lost events.
    Raises BadValue for a capacity below 1.
    """

    __slots__ = ("_events", "_lost", "_mask", "capacity", "overflowed")

    def __init__(self, capacity: int, mask: int = EVERY_EVENT) -> None:
        if capacity < 1:
            raise BadValue(f"event queue for {capacity} events: it needs a capacity of 1 or more")
        self.capacity = capacity
        self.overflowed = 0  # events lost so far because the queue was full
        self._mask = int(mask)
        self._events: deque[Event] = deque()
        self._lost = 0  # since the newest event in the queue

    def __len__(self) -> int:
        return len(self._events)

    @property
    def mask(self) -> int:
        """The event mask. A narrower mask deletes waiting events of other types immediately and for good."""
        return self._mask

    @mask.setter
    def mask(self, mask: int) -> None:
        if not isinstance(mask, int) or not 0 <= mask <= DWORD:
            raise BadValue(f"event mask {mask!r:.40}: a whole number of 32 bits")
        dropped = self._mask & ~mask
        self._mask = int(mask)
        if dropped and self._events:
            self._delete()

    def _delete(self) -> None:
        """Worked example of 8.7: the next event counts a deleted event as one, and adds that event's count."""
        kept: deque[Event] = deque()
        missing = 0
        for event in self._events:
            if not event.event & self._mask:
                missing += 1 + event.lost
            else:
                kept.append(event._replace(lost=_counted(event.lost + missing)) if missing else event)
                missing = 0
        self._events = kept
        self._lost += missing

    @property
    def lost(self) -> int:
        """The number of lost events that the next stored event will contain."""
        return self._lost

    def push(self, event: Event) -> bool:
        """Store the event with the count of those lost before it; False if its type is masked or the queue is full."""
        if not event[0] & self._mask:
            return False
        events = self._events
        if len(events) >= self.capacity:
            self._lost += 1
            self.overflowed += 1
            return False
        if self._lost:
            event = event._replace(lost=_counted(event.lost + self._lost))
            self._lost = 0
        events.append(event)
        return True

    def lose(self, count: int = 1) -> None:
        """Count events that were lost before they reached the queue."""
        self._lost += count
        self.overflowed += count

    def pop(self) -> Event | None:
        """Remove the oldest event and return it; None if the queue is empty."""
        return self._events.popleft() if self._events else None

    def peek(self) -> int:
        """The type of the oldest event, which stays in the queue (WaitCommEvent); 0 if the queue is empty."""
        return self._events[0][0] if self._events else 0

    def put_back(self, event: Event) -> None:
        """Make an event that `pop` returned the oldest one again."""
        self._events.appendleft(event)

    def clear(self) -> None:
        """Delete all events and the count of lost ones, so that the queue is as in a new receive channel."""
        self._events.clear()
        self._lost = 0


def _counted(lost: int) -> int:
    """The count limited to 32 bits."""
    return min(lost, DWORD)
