# cython: nonecheck=False
"""The queues of one client on a line: filters, receive ring, transmit ring, and exact counters.

At any moment `accepted` = read + waiting + `lost`, and `sent` = `delivered` + `aborted` + `refused` + `pending()`.
`lost` are frames and events that came when the receive ring was full.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections import deque
from collections.abc import Callable

from canwire import _mem
from canwire.boards.can.message_filter import ALWAYS, MessageFilter
from canwire.boards.can.modes import Siblings
from canwire.bus.can.node import Mailbox, Sink
from canwire.ring import Ring
from canwire.values.acceptance import (
    KEY_EXTENDED,
    KEY_ID_SHIFT,
    KEY_NO_BYTE_0,
    KEY_NO_BYTE_1,
    KEY_REMOTE,
    Acceptance,
)
from canwire.values.checks import instance

VCI_REQUESTS = 1 << 8 | 1 << 9 | 1 << 10 | 1 << 11 | 0xF << 16 | 1 << 21 | 1 << 22 | 1 << 23
ALL_REQUESTS = VCI_REQUESTS | 1 << 13 | 1 << 14 | 1 << 24
"""What VCI knows, and with our own requests, whose bits other programs may leave as they happen to be."""
_OVERRUN = 1 << 20
_REMOTE = 1 << 22
_EXTENDED = 1 << 23
_HIGH_PRIORITY = 1 << 9
_CONFIRM = 1 << 13
_SELF_RECEPTION = 1 << 21
_FD = 1 << 10
_ALWAYS = ALWAYS
_ACCEPTED = ALWAYS << 24
_M32 = 0xFFFFFFFF
_OWN_FILTERED, _ALL, _OWN, _AS_BUS, _EVERY, _OTHERS, _OTHERS_AND_OWN = (int(kind) for kind in Siblings)
# the part of an id/info word that is the frame: identifier, format, DLC; without the sender's requests
_FRAME_BITS = 0x1FFFFFFF | (1 << 10 | 1 << 11 | 1 << 12 | 0xF << 16 | 1 << 22 | 1 << 23) << 32

# values/acceptance.py's key
_KEY_EXTENDED = KEY_EXTENDED
_KEY_REMOTE = KEY_REMOTE
_KEY_NO_BYTE_1 = KEY_NO_BYTE_1
_KEY_NO_BYTES = KEY_NO_BYTE_0 | KEY_NO_BYTE_1
_KEY_OF_HEAD = KEY_EXTENDED | KEY_REMOTE | 0x1FFFFFFF << KEY_ID_SHIFT  # what the id/info word alone tells

Outcome = Callable[[bool, int], None]


class Channel(Sink):
    """Queues between one client and a line.

    `receive` and `transmit` are rings of records; a transmit record's time word is the delay in ns after
    the frame that this channel sent before. A transmit capacity of 0 makes a channel that only receives.
    `frames` and `events` (EventKinds) say what the channel receives, `siblings` which frames that its own line sends.
    With `tick_ns` records are stamped with 32 bits of a counter of such ticks that began at `origin_ns`.
    `allowed` are the info bits that a sender may set: of the frame itself, and requests.
    Frames of a `prioritised` channel wait for the line in the order of their priorities, which are in the high half
    of their time words. Another process writes the transmit ring of an `untrusted` channel: the line checks each
    record, reads its time word as `delay_tick_ns` ticks (at most `longest_delay`), and counts `refused` ones.
    Frames sent by a channel that `stands_for` another one count as frames of that other channel.
    Programs of its interface, `kin`, set `line_filter`, `hears_errors`, and what it may send (hearing.py).
    """

    def __cinit__(self, *_: object, **__: object) -> None:
        """Compiled: what was never initialised has all its parts, since no access to them is checked."""
        self.receive = self.transmit = Ring.__new__(Ring)
        self._outcomes: tuple[deque[Outcome], deque[Outcome]] = (deque(), deque())

    def __init__(
        self,
        receive_capacity: int,
        transmit_capacity: int,
        *,
        frames: bool = True,
        events: frozenset[int] = frozenset(),
        siblings: int = 0,
        rings: tuple[Ring, Ring | None] | None = None,
    ) -> None:
        receive, transmit = rings or (Ring(receive_capacity), Ring(max(1, transmit_capacity)))
        instance("receive", receive, Ring)
        self.receive = receive
        self.sends = transmit_capacity > 0 and transmit is not None
        self.transmit = Ring(1) if transmit is None else transmit
        self.frames = frames
        self.events = events
        self.siblings = siblings
        self.filter: MessageFilter | None = None
        self.kin = ""
        self.line_filter: MessageFilter | None = None
        self.hears_errors = self.standard = self.extended = True
        self.untrusted = False
        self.prioritised = False
        self.allowed = VCI_REQUESTS
        self.fd = True
        self.stands_for: Channel | None = None
        self.tick_ns = 0
        self.origin_ns = 0
        self.delay_tick_ns = 1
        self.longest_delay = 1 << 40
        self.accepted = self.lost = self.sent = self.delivered = self.aborted = self.refused = 0
        self.in_flight = 0
        self.last_sent_ns = 0
        self.held = self.paused = False
        self.urgent = 0
        self._overrun_due = False
        self._outcomes = (deque(), deque())
        self.set_acceptance(None)

    def set_acceptance(self, acceptance: Acceptance | None) -> None:
        """Accept only these frames from now on; None accepts all frames."""
        self.acceptance = acceptance
        pairs = () if acceptance is None else acceptance.pairs
        listed = () if acceptance is None else acceptance.identifiers
        self._open = acceptance is None or any(mask == 0 for _, mask in pairs)
        by_head = [(_head_of(code), _head_of(mask)) for code, mask in pairs if not mask & ~_KEY_OF_HEAD]
        by_key = [pair for pair in pairs if pair[1] & ~_KEY_OF_HEAD]
        self._pairs_block = array("Q", [word for pair in by_head + by_key for word in pair] or [0])
        self._pairs = _mem.words_of(self._pairs_block)
        self._head_words = 2 * len(by_head)
        self._pair_words = 2 * len(pairs)
        self._listed = sorted(listed)
        self._by_head = not by_key and not listed

    def pending(self) -> int:
        """The number of sent frames that wait for the bus, those in the controller included."""
        return self.in_flight + self.transmit.fill()

    def gated(self) -> bool:
        """Whether frames from the bus pass another filter before the channel's own: they come through `arrive`."""
        return self.line_filter is not None or (self.filter is not None and not self._open)

    def arrive(self, box: Mailbox, at_ns: int, flags: int, looped: bool) -> None:
        """Deliver a frame that passes the filters of the line and the interface; a `looped` frame passes registers."""
        code = 0
        if self.line_filter is not None:
            code = self.line_filter.judge(box.words[1])
        if code == 0 and self.line_filter is not None:
            pass
        elif self.filter is None or self._open or looped or self._passes(box.words, box.words[1]):
            self.deliver(box, at_ns, flags | code << 24)

    def deliver(self, box: Mailbox, at_ns: int, flags: int) -> None:
        """Deliver a frame for this channel if its filter accepts it; `flags` are more info bits."""
        if not self.fd and box.words[1] >> 32 & _FD:
            pass  # nothing that its client could read
        elif self.filter is not None:
            self._take_judged(box, at_ns, flags, self.filter.judge(box.words[1]))
        elif self._open or self._passes(box.words, box.words[1]):
            self._take(box, at_ns, box.words[1], flags)

    def deliver_sent(self, box: Mailbox, at_ns: int) -> None:
        """Deliver a frame that this channel's own line sent, as `siblings` says."""
        head = box.words[1]
        if self.siblings == _EVERY:
            self.deliver(box, at_ns, _SELF_RECEPTION)
        elif self.siblings >= _OTHERS:
            if not (box.owner is self or box.owner.stands_for is self):
                self.deliver(box, at_ns, 0)
            elif self.siblings == _OTHERS_AND_OWN:
                self.deliver(box, at_ns, _SELF_RECEPTION)
        elif head >> 32 & _SELF_RECEPTION == 0 or (not self.fd and head >> 32 & _FD):
            pass  # invisible to its own line's channels, as on real boards
        elif self.siblings == _OWN_FILTERED:
            self.deliver(box, at_ns, _SELF_RECEPTION)
        elif self.siblings == _ALL or box.owner is self:
            self._take(box, at_ns, head, _SELF_RECEPTION | _ACCEPTED)
        elif self.siblings == _AS_BUS:
            self.deliver(box, at_ns, 0)

    def return_own(self, box: Mailbox, at_ns: int) -> None:
        """Deliver a frame of this channel that requested self-reception; it bypasses the filter and is marked."""
        self._take(box, at_ns, box.words[1], _SELF_RECEPTION | _ACCEPTED)

    def deliver_event(self, record: bytes, stamped: bool = True) -> None:
        """Deliver an event's record; filters do not apply. Without `stamped` its time does not change."""
        block = bytearray(record)
        words = _mem.words_of(block)
        self.accepted += 1
        time_ns = words[0]
        if stamped and self.tick_ns:
            time_ns = self._stamp(time_ns)
        if not self.receive.put(words, 0, time_ns, words[1]):
            self.lost += 1
            self._overrun_due = True

    def drop_queued(self, at_ns: int) -> None:
        """Discard every frame in the transmit ring, and report those with CONFIRM as not delivered."""
        if self.untrusted:
            count = self.transmit.clear()
            self.sent += count
            self.aborted += count
            return
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

    def _stamp(self, at_ns: int) -> int:
        return (at_ns - self.origin_ns) // self.tick_ns & _M32

    def _take_judged(self, box: Mailbox, at_ns: int, flags: int, code: int) -> None:
        if code != _ALWAYS or flags >> 24 == 0:
            flags = flags & 0xFFFFFF | code << 24
        if code:
            self._take(box, at_ns, box.words[1], flags)

    def _take(self, box: Mailbox, at_ns: int, head: int, flags: int) -> None:
        self.accepted += 1
        head &= _FRAME_BITS
        if flags:
            head |= flags << 32
        if self._overrun_due:
            head |= _OVERRUN << 32
        if self.tick_ns:
            at_ns = self._stamp(at_ns)
        if self.receive.put(box.words, 0, at_ns, head):
            self._overrun_due = False
        else:
            self.lost += 1
            self._overrun_due = True

    def expect_outcome(self, high_priority: bool, outcome: Outcome) -> None:
        """Call `outcome(delivered, at_ns)` for the frame sent last with CONFIRM in its info."""
        self._outcomes[high_priority].append(outcome)

    def tell_outcome(self, box: Mailbox, delivered: bool, at_ns: int) -> None:
        """Call the oldest outcome that waits; frames of one priority leave in the order in which they were sent."""
        waiting = self._outcomes[box.words[1] >> 32 & _HIGH_PRIORITY != 0]
        if waiting:
            waiting.popleft()(delivered, at_ns)

    def _passes(self, words: _mem.Words, head: int) -> bool:
        pairs = self._pairs
        for k in range(0, self._head_words, 2):
            if (head ^ pairs[k]) & pairs[k + 1] == 0:
                return True
        return not self._by_head and self._passes_by_key(words, head)

    def _passes_by_key(self, words: _mem.Words, head: int) -> bool:
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
        for k in range(self._head_words, self._pair_words, 2):
            if (key ^ self._pairs[k]) & self._pairs[k + 1] == 0:
                return True
        return bool(self._listed) and self._is_listed(identifier, info)

    def _is_listed(self, identifier: int, info: int) -> bool:
        wanted = identifier << 1 | (1 if info & _REMOTE else 0) | (1 << 31 if info & _EXTENDED else 0)
        at = bisect_left(self._listed, wanted)
        return at < len(self._listed) and self._listed[at] == wanted


class Splitter(Sink):
    """Copies each frame to every channel."""

    def __init__(self) -> None:
        self.channels: list[Channel] = []

    def deliver(self, box: Mailbox, at_ns: int, flags: int) -> None:
        self._deliver(box, at_ns, flags, False)

    def loop_back(self, box: Mailbox, at_ns: int) -> None:
        """Deliver a frame that comes from the line itself and not from the bus."""
        self._deliver(box, at_ns, 0, True)

    def _deliver(self, box: Mailbox, at_ns: int, flags: int, looped: bool) -> None:
        for channel in self.channels:
            channel.arrive(box, at_ns, flags, looped)


def _head_of(key: int) -> int:
    """The part of a key, or of a mask over it, that is in a record's id/info word, in the positions of that word."""
    info = (_EXTENDED if key & KEY_EXTENDED else 0) | (_REMOTE if key & KEY_REMOTE else 0)
    return key >> KEY_ID_SHIFT & 0x1FFFFFFF | info << 32
