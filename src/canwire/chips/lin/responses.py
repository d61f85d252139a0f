"""The response table of a LIN controller: the response to each header, and when the response ends.

Source: VCI V4 manual 5.3.3; LIN 2.2A 2.3.3.2 (event-triggered frames), 2.7.3 (response error bit).
"""

from __future__ import annotations

from typing import NamedTuple

from canwire.bus.lin.node import IDENTIFIERS, LinResponse
from canwire.values.lin.frame import protected_id


class _Entry(NamedTuple):
    data: bytes
    enhanced: bool
    once: bool


class Role(NamedTuple):
    """The state of a frame in the table: its entry, whether it was updated, the events that it is associated with,
    the frame that it replaces as an event, and which of its bits is the response-error bit.
    """

    entry: _Entry | None
    updated: bool
    events: tuple[int, ...]
    behind: int | None
    status_bit: int | None


class ResponseTable:
    """`responses` is read by the bus, by identifier; `updated` the identifiers with data not sent yet, and
    `watched` others whose sending also changes something.

    `spaces` are the bits before the first byte of a response and between any two. `response_error` is the
    value of the response-error bit, where one was asked for.
    """

    def __init__(self) -> None:
        self.responses: list[LinResponse | None] = [None] * IDENTIFIERS
        self.updated: set[int] = set()
        self.spaces = (0, 0)
        self.response_error = False
        self._entries: dict[int, _Entry] = {}
        self._events: dict[int, int] = {}
        self._status_bit: tuple[int, int] | None = None
        self.watched: set[int] = set()

    def clear(self) -> None:
        """Empty the table, and discard all settings of frames."""
        self.responses[:] = [None] * IDENTIFIERS
        self._entries.clear()
        self._events.clear()
        self.updated.clear()
        self.watched.clear()
        self._status_bit = None

    def put(self, id: int, data: bytes, enhanced: bool, once: bool) -> None:
        """Answer this header with these data from now on, or `once`."""
        before = self._entries.get(id)
        self._entries[id] = _Entry(data, enhanced, once)
        if before is None or before.data != data or once:
            self.updated.add(id)
        if once:
            self.watched.add(id)
        self._fill(id)

    def remove(self, id: int) -> None:
        """Stop answering this header."""
        self._entries.pop(id, None)
        self.updated.discard(id)
        for number in (id, *self._events_of(id)):
            self.responses[number] = None

    def associate(self, event: int, id: int) -> None:
        """Answer the event-triggered `event` with the response of `id` if that was updated.

        The first byte of that response is its protected identifier from now on, instead of the byte in its data.
        """
        self._events[event] = id
        self.watched |= {event, id}
        self._fill(id)

    def take(self, id: int) -> Role:
        """Remove the frame and return its state, to be placed under another identifier, or to be kept meanwhile."""
        entry, updated, events = self._entries.get(id), id in self.updated, tuple(self._events_of(id))
        status_bit = None
        if self._status_bit is not None and self._status_bit[0] == id:
            status_bit, self._status_bit = self._status_bit[1], None
        self.remove(id)
        for event in events:
            del self._events[event]
        return Role(entry, updated, events, self._events.pop(id, None), status_bit)

    def place(self, id: int, role: Role) -> None:
        """Put a removed frame under this identifier."""
        if role.entry is not None:
            self._entries[id] = role.entry
            if role.updated:
                self.updated.add(id)
            if role.entry.once:
                self.watched.add(id)
        if role.status_bit is not None:
            self.put_status_bit(id, role.status_bit)
        for event in role.events:
            self.associate(event, id)
        if role.behind is not None:
            self.associate(id, role.behind)
        self._fill(id)

    def is_event(self, id: int) -> bool:
        return id in self._events

    def put_status_bit(self, id: int, bit: int) -> None:
        """Make this bit of this response the response-error bit."""
        self._status_bit = (id, bit)
        self.watched.add(id)
        self._fill(id)

    def set_response_error(self, value: bool) -> None:
        if value != self.response_error:
            self.response_error = value
            if self._status_bit is not None:
                self._fill(self._status_bit[0])

    def refill(self) -> None:
        """Build all responses again, for changed spaces."""
        for id in self._entries:
            self._fill(id)

    def make(self, id: int, data: bytes, enhanced: bool) -> LinResponse:
        """A response with its checksum and the present spaces."""
        space, gap = self.spaces
        return LinResponse.to_send(id, data, enhanced, space_bits=space, gap_bits=gap)

    def sent(self, id: int) -> None:
        """Note that the response to this header was sent."""
        self.updated.discard(id)
        if id in self.watched:
            self._sent(self._events.get(id, id))

    def _sent(self, id: int) -> None:
        """Update the settings that depend on a sent response of `id`, sent under its own identifier or an event's."""
        self.updated.discard(id)
        for event in self._events_of(id):
            self.responses[event] = None
        entry = self._entries.get(id)
        if entry is not None and entry.once:
            self.remove(id)
        elif self.response_error and self._status_bit is not None and self._status_bit[0] == id:
            self.set_response_error(False)

    def _fill(self, id: int) -> None:
        """Compute the response to this header, and to the event-triggered headers of this frame."""
        entry = self._entries.get(id)
        if entry is None:
            return
        data = entry.data
        events = self._events_of(id)
        if events:
            data = bytes([protected_id(id)]) + data[1:]
        if self._status_bit is not None and self._status_bit[0] == id:
            data = _with_bit(data, self._status_bit[1], self.response_error)
        self.responses[id] = self.make(id, data, entry.enhanced)
        for event in events:
            self.responses[event] = self.make(event, data, entry.enhanced) if id in self.updated else None

    def _events_of(self, id: int) -> list[int]:
        return [event for event, behind in self._events.items() if behind == id]


def _with_bit(data: bytes, bit: int, value: bool) -> bytes:
    changed = bytearray(data)
    if bit < 8 * len(changed):
        changed[bit // 8] = changed[bit // 8] & ~(1 << bit % 8) | value << bit % 8
    return bytes(changed)
