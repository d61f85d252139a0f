"""One client's queues on a line: acceptance filter, receive ring, transmit ring, and honest counters.

At any moment `accepted` = read + waiting + `lost`, and `sent` = `delivered` + `aborted` + `pending()`.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections import deque
from collections.abc import Callable

from canwire import _mem
from canwire.bus.node import Mailbox, Sink
from canwire.ring import Ring
from canwire.values.acceptance import (
    KEY_EXTENDED,
    KEY_NO_BYTE_0,
    KEY_NO_BYTE_1,
    KEY_REMOTE,
    Acceptance,
)

_OVERRUN = 1 << 20
_REMOTE = 1 << 22
_EXTENDED = 1 << 23
_HIGH_PRIORITY = 1 << 9
_CONFIRM = 1 << 13
# what of a frame's id/info word is the frame itself: identifier, format, DLC; requests of the sender are not
_FRAME_BITS = 0x1FFFFFFF | (1 << 10 | 1 << 11 | 1 << 12 | 0xF << 16 | 1 << 22 | 1 << 23) << 32

# values/acceptance.py's key
_KEY_EXTENDED = KEY_EXTENDED
_KEY_REMOTE = KEY_REMOTE
_KEY_NO_BYTE_1 = KEY_NO_BYTE_1
_KEY_NO_BYTES = KEY_NO_BYTE_0 | KEY_NO_BYTE_1

Outcome = Callable[[bool, int], None]


class Channel(Sink):
    """Queues between one client and a line.

    `receive` and `transmit` are rings of records; a transmit record's time word is the delay in ns after
    the frame that this channel sent before. A transmit capacity of 0 makes a channel that only receives.
    `frames` and `events` (EventKinds) say what the channel wants to receive.
    """

    def __init__(
        self,
        receive_capacity: int,
        transmit_capacity: int,
        *,
        frames: bool = True,
        events: frozenset[int] = frozenset(),
    ) -> None:
        self.receive = Ring(receive_capacity)
        self.sends = transmit_capacity > 0
        self.transmit = Ring(max(1, transmit_capacity))
        self.frames = frames
        self.events = events
        self.accepted = 0
        self.sent = 0
        self.delivered = 0
        self.aborted = 0
        self.last_sent_ns = 0
        self.held = False
        self.urgent = 0
        self._overrun_due = False
        self._outcomes: tuple[deque[Outcome], deque[Outcome]] = (deque(), deque())
        self.set_acceptance(None)

    def set_acceptance(self, acceptance: Acceptance | None) -> None:
        """Let only these frames in from now on; None lets all of them in."""
        self.acceptance = acceptance
        pairs = () if acceptance is None else acceptance.pairs
        listed = () if acceptance is None else acceptance.identifiers
        self._open = acceptance is None or any(mask == 0 for _, mask in pairs)
        self._pairs_block = array("Q", [word for pair in pairs for word in pair] or [0])
        self._pairs = _mem.words_of(self._pairs_block)
        self._pair_count = len(pairs)
        self._listed = sorted(listed)

    @property
    def lost(self) -> int:
        """Accepted frames and events that found the receive ring full."""
        return self.receive.lost

    def pending(self) -> int:
        """Frames sent that wait for the bus, those in the controller included."""
        return self.sent - self.delivered - self.aborted

    def deliver(self, box: Mailbox, at_ns: int, flags: int) -> None:
        """A frame for this channel, unless its filter says otherwise; `flags` are more info bits."""
        self._offer(box, box.words[1], at_ns, flags)

    def deliver_event(self, record: bytes) -> None:
        """An event's record; filters do not apply."""
        self.accepted += 1
        self.receive.put_bytes(record)

    def drop_queued(self, at_ns: int) -> None:
        """Give up every frame that waits in the transmit ring, and tell who asked about them."""
        asked = [0, 0]
        while (record := self.transmit.take_bytes()) is not None:
            info = int.from_bytes(record[12:16], "little")
            self.aborted += 1
            if info & _CONFIRM:
                asked[1 if info & _HIGH_PRIORITY else 0] += 1
        self.urgent = 0
        for outcomes, count in zip(self._outcomes, asked, strict=True):
            # the frames in the controller were sent before these: theirs are the newest outcomes
            for outcome in [outcomes.pop() for _ in range(count)][::-1]:
                outcome(False, at_ns)

    def _offer(self, box: Mailbox, head: int, at_ns: int, flags: int) -> None:
        if self._open or self._passes(box.words, head):
            self._take(box, at_ns, head, flags)

    def _take(self, box: Mailbox, at_ns: int, head: int, flags: int) -> None:
        self.accepted += 1
        head &= _FRAME_BITS
        if flags:
            head |= flags << 32
        if self._overrun_due:
            head |= _OVERRUN << 32
        if self.receive.put(box.words, 0, at_ns, head):
            self._overrun_due = False
        else:
            self._overrun_due = True

    def expect_outcome(self, high_priority: bool, outcome: Outcome) -> None:
        """Call `outcome(delivered, at_ns)` for the frame sent last with CONFIRM in its info."""
        self._outcomes[high_priority].append(outcome)

    def tell_outcome(self, box: Mailbox, delivered: bool, at_ns: int) -> None:
        """Frames of one priority leave in the order in which they were sent."""
        waiting = self._outcomes[box.words[1] >> 32 & _HIGH_PRIORITY != 0]
        if waiting:
            waiting.popleft()(delivered, at_ns)

    def _passes(self, words: _mem.Words, head: int) -> bool:
        info = head >> 32
        identifier = head & 0x1FFFFFFF
        key = identifier << 17
        length = info >> 16 & 15
        if info & _EXTENDED:
            key |= _KEY_EXTENDED
        if info & _REMOTE:
            key |= _KEY_REMOTE
            length = 0
        if length < 2:
            key |= _KEY_NO_BYTE_1 if length else _KEY_NO_BYTES
        data = words[2]  # bytes beyond the frame's length are zero in every record
        key |= (data & 0xFF) << 8 | (data >> 8 & 0xFF)
        for k in range(self._pair_count):
            if (key ^ self._pairs[2 * k]) & self._pairs[2 * k + 1] == 0:
                return True
        return bool(self._listed) and self._is_listed(identifier, info)

    def _is_listed(self, identifier: int, info: int) -> bool:
        wanted = identifier << 1 | (1 if info & _REMOTE else 0) | (1 << 31 if info & _EXTENDED else 0)
        at = bisect_left(self._listed, wanted)
        return at < len(self._listed) and self._listed[at] == wanted
