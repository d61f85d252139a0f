"""Turns the records of a channel into a handle's events: filters, the outcome of sent messages, changes of state.

This module neither locks nor waits: the handle does. Source: CANDRV manual, 7.5 to 7.9, 8.20, 8.23.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from canwire import SELF_RECEPTION, CanwireError, ErrorState, EventKind
from canwire.candrv.constants import CanbusEvent, CanMode, FrameFormat
from canwire.candrv.device.state import DeviceState, can_time
from canwire.candrv.event_queue import Event, EventQueue
from canwire.candrv.filters import ID_SHIFT, Filter, identifier_width

if TYPE_CHECKING:
    from canwire import RingEnd

# a record of the hub's (values/record.py): time or delay, identifier, info, the first eight bytes
RECORD = struct.Struct("<QII8s56x")
REMOTE, EXTENDED = 1 << 22, 1 << 23
DLC_SHIFT = 16
_MESSAGE_BITS = 0xF << DLC_SHIFT | REMOTE | EXTENDED
_STATE_AT = 2  # index in an event's data of its ErrorState, with a bit for the sender
_STATE_BITS = 0x7F
_LEVEL = {ErrorState.ERROR_WARNING: 1, ErrorState.ERROR_PASSIVE: 2, ErrorState.BUS_OFF: 3}
_STEPS = (CanbusEvent.WARNING, CanbusEvent.PASSIVE, CanbusEvent.BUS_ERROR)
_PLAIN = {
    int(EventKind.ARBITRATION_LOST): CanbusEvent.ARBITRATION_LOST,
    int(EventKind.OVERRUN): CanbusEvent.OVERRUN,
    int(EventKind.CHANGED): CanbusEvent.DEVICE_CHANGED,
    int(EventKind.SLEEPING): CanbusEvent.ENTERING_STANDBY,
    int(EventKind.WOKEN): CanbusEvent.LEAVING_STANDBY,
}
EVENTS = (*_PLAIN, int(EventKind.STATE))
"""The events that a receive channel asks the hub for; ABORTED always goes to the channel that sent the message."""
_STATE, _CHANGED, _ABORTED = int(EventKind.STATE), int(EventKind.CHANGED), int(EventKind.ABORTED)
_RECEIVED = int(CanbusEvent.RECEIVED)
_event = tuple.__new__  # Event's own __new__ takes twice as long


class Key(NamedTuple):
    """What distinguishes messages: identifier, DLC and format bits, data."""

    identifier: int
    info: int
    data: bytes


class Ticket:
    """A message that was queued; `done` is True once it counts as sent or was `aborted`."""

    __slots__ = ("aborted", "done", "key", "loaded")

    def __init__(self, key: Key, *, counts_loaded: bool) -> None:
        self.key = key
        self.done = self.aborted = False
        self.loaded = not counts_loaded  # whether the confirmation of loading has arrived, or is not expected


class Receiver:
    """Turns the records of one handle's channel into events. `queue` None: only the outcome of messages matters.

    `look` returns the state of the device; it is called again after each change.
    """

    def __init__(
        self,
        queue: EventQueue | None,
        *,
        look: Callable[[], DeviceState],
        align: int,
        tells_sent: bool,
        level: int,
    ) -> None:
        self.queue = queue
        self.state = look()
        self.filter = Filter.everything()
        self.tickets: deque[Ticket] = deque()
        self._look = look
        self._tells_sent = tells_sent
        self._level = _LEVEL.get(ErrorState(level), 0)
        self._ring_lost = 0
        self._align = align
        self._widths = identifier_width(False, align), identifier_width(True, align)
        self._shifts = ID_SHIFT[align]

    def take(self, end: RingEnd) -> None:
        """Turn all records in the channel into events, or count them as lost, as if each were handled on arrival."""
        ring = end.ring
        count = 0
        for block in ring.acquire(ring.capacity):
            count += len(block) // RECORD.size
            self._take_block(block)
        if count:
            ring.release(count)
        lost = ring.lost
        if lost != self._ring_lost:  # no call handled records for so long that the channel was full
            if self.queue is not None:
                self.queue.lose(lost - self._ring_lost)
            self._ring_lost = lost

    def gave_up(self, count: int, at_ns: int) -> None:
        """Report that the last `count` messages were aborted before the controller had them."""
        dropped = [self.tickets.pop() for _ in range(min(count, len(self.tickets)))]
        for ticket in reversed(dropped):
            self._abort(ticket, at_ns)

    def _take_block(self, block: memoryview) -> None:
        queue, accepts = self.queue, self.filter.accepts
        widths, shifts = self._widths, self._shifts
        for at_ns, identifier, info, data in RECORD.iter_unpack(block):
            if info & 0xFF:
                self._happened(info & 0xFF, at_ns, data)
                continue
            if info & SELF_RECEPTION:
                self._confirmed(Key(identifier, info & _MESSAGE_BITS, data), at_ns)
                continue
            if queue is None:
                continue
            extended = 1 if info & EXTENDED else 0
            if extended and self.state.mode != CanMode.CAN_2_0_B:
                continue
            dlc = info >> DLC_SHIFT & 0xF
            remote = 1 if info & REMOTE else 0
            shown = b"" if remote else data if dlc >= 8 else data[:dlc]
            if not accepts(identifier, extended != 0, shown):
                continue
            word = (identifier & widths[extended]) << shifts[extended]
            time = at_ns // 1_000_000 & 0xFFFF_FFFF
            queue.push(_event(Event, (_RECEIVED, time, 0, 1 + extended, word, remote, dlc, shown)))

    def _happened(self, kind: int, at_ns: int, data: bytes) -> None:
        if kind == _STATE:
            self._move(_LEVEL.get(ErrorState(data[_STATE_AT] & _STATE_BITS), 0), at_ns)
        elif kind == _ABORTED:
            if self.tickets:
                self._abort(self.tickets.popleft(), at_ns)
        elif kind in _PLAIN:
            if kind == _CHANGED:
                with suppress(CanwireError):  # the caller's next request raises it
                    self.state = self._look()
            self._post(_PLAIN[kind], at_ns)

    def _move(self, level: int, at_ns: int) -> None:
        """Report each error level once, also if the controller passed two levels in one step."""
        for step in range(self._level, level):
            self._post(_STEPS[step], at_ns)
        self._level = level

    def _post(self, event: CanbusEvent, at_ns: int) -> None:
        if self.queue is not None:
            self.queue.push(Event(int(event), can_time(at_ns)))

    def _confirmed(self, key: Key, at_ns: int) -> None:
        """The controller has loaded a message, or has sent it: the confirmations arrive in this order."""
        ticket = self._ticket(key)
        if ticket is None:
            return
        if not ticket.loaded:
            ticket.loaded = True
        else:
            self.tickets.popleft()
        if not ticket.done:
            ticket.done = True
            if self._tells_sent:
                self._post_message(CanbusEvent.TRANSMITTED, key, at_ns)

    def _ticket(self, key: Key) -> Ticket | None:
        """The oldest message with this key; the confirmations of those before it were lost in a full channel."""
        tickets = self.tickets
        if tickets and tickets[0].key == key:
            return tickets[0]
        if not any(ticket.key == key for ticket in tickets):
            return None
        while tickets[0].key != key:
            tickets.popleft().done = True
        return tickets[0]

    def _abort(self, ticket: Ticket, at_ns: int) -> None:
        """Report an aborted message, unless it counted as sent when the controller loaded it."""
        if not ticket.done:
            ticket.done = ticket.aborted = True
            self._post_message(CanbusEvent.ABORTED, ticket.key, at_ns)

    def _post_message(self, event: CanbusEvent, key: Key, at_ns: int) -> None:
        if self.queue is None:
            return
        identifier, info, data = key
        extended = 1 if info & EXTENDED else 0
        dlc, remote = info >> DLC_SHIFT & 0xF, 1 if info & REMOTE else 0
        word = (identifier & self._widths[extended]) << self._shifts[extended]
        fmt = FrameFormat.EXT if extended else FrameFormat.STD
        shown = b"" if remote else data[:dlc]
        self.queue.push(Event(int(event), can_time(at_ns), 0, int(fmt), word, remote, dlc, shown))
