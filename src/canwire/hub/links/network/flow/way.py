"""Flow control in one direction: how many bytes may be in transit, and how long small batches wait.

Data that queue in a slow network delay the calls and signs of life after them. So the window limits the bytes in
transit: it shrinks if batches take longer than the fastest ones by more than QUEUE_NS, and it grows while it is full
and they do not. On a slow network, batches are larger and compressed.
"""

from __future__ import annotations

import threading

WINDOW = 1 << 19  # bytes under way at most, that nobody has said to have come: a network of 1 Gbit/s at 4 ms
FIRST, LEAST = 1 << 12, 1 << 11
_HEAD = 40  # bytes that go with each payload
HOLD_NS = 1_000_000  # records that came within so long go together ...
AT_ONCE = 4  # ... once there were so many smaller batches in that time
_SLOW_HOLD_NS = 50_000_000
_FEW = 4  # clients of one hub; more wait this much longer each ...
_MORE_NS = 600_000  # ... as a thread that wakes up for a frame or two costs more than the frame
QUEUE_NS = 200_000_000  # beyond the quickest way
_ROUND_NS = 10_000_000_000  # the quickest way of so long ago is no longer believed
_NEVER = 1 << 62


class Way:
    """The window that all outgoing rings of a link share; it starts with `limit` bytes, and may lead through a relay.

    No clock: times in ns are arguments; any thread may call.
    """

    def __init__(self, limit: int = FIRST, *, relayed: bool = False) -> None:
        self._lock = threading.Lock()
        self._limit, self._under_way = limit, 0
        self._full = False  # something had to wait since the window was changed ...
        self._waits = False  # ... and still does
        self._changed_ns = -_NEVER
        self._quickest_ns, self._quickest_before_ns = _NEVER, _NEVER
        self._round_ns = -_NEVER
        self.slow = False
        self._relayed = relayed
        self._crowd_ns = 0

    def shared_with(self, clients: int) -> None:
        """Set the number of clients that this process serves."""
        self._crowd_ns = max(0, clients - _FEW) * _MORE_NS

    @property
    def hold_ns(self) -> int:
        """How long small batches wait for each other."""
        return HOLD_NS + max(self._crowd_ns, _SLOW_HOLD_NS if self.slow else 0)

    @property
    def squeezes(self) -> bool:
        """Whether batches are compressed one by one; a relay compresses those of all programs together."""
        return self.slow and not self._relayed

    @property
    def at_once(self) -> int:
        """The number of small batches within that time that need not wait."""
        return 1 if self.slow or self._crowd_ns else AT_ONCE

    def room(self) -> int:
        """Bytes that may be sent now; 0 below a quarter of the window, which small payloads would fill badly."""
        found = self._limit - self._under_way
        if found < self._limit // 4:
            self._full = self._waits = True
            return 0
        return found

    @property
    def asks(self) -> bool:
        """Whether the other end should report soon what has arrived."""
        return self.slow or (self._full and self._limit < WINDOW)

    def waits(self) -> bool:
        """Whether something had no room; True only once."""
        found, self._waits = self._waits, False
        return found

    def sent(self, size: int) -> None:
        """A payload of this size in bytes is in transit."""
        with self._lock:
            self._under_way += size + _HEAD

    def gone(self, size: int, payloads: int) -> None:
        """Remove this number of bytes from the window: they arrived, or are sent again."""
        with self._lock:
            self._under_way -= size + payloads * _HEAD

    def came(self, sent_ns: int, now_ns: int) -> None:
        """The payload that was sent at `sent_ns` has arrived."""
        took_ns = max(0, now_ns - sent_ns)
        with self._lock:
            queue_ns = took_ns - self._quickest(took_ns, now_ns)
            if sent_ns < self._changed_ns or not self._full:
                return  # of the window before, or there is room: then it is the other machine that takes its time
            if queue_ns > QUEUE_NS:
                self._limit = max(LEAST, min(self._limit, self._limit * QUEUE_NS // queue_ns))
                self.slow = True
            elif queue_ns < QUEUE_NS // 2:
                self._limit = min(WINDOW, self._limit * 5 // 4 if self.slow else self._limit * 2)
                self.slow &= self._limit < WINDOW
            else:
                return
            self._changed_ns, self._full = now_ns, False

    def _quickest(self, took_ns: int, now_ns: int) -> int:
        """The quickest way of this round and the one before; each begins with little under way, to see it again."""
        if now_ns >= self._round_ns + _ROUND_NS:
            self._quickest_before_ns, self._quickest_ns = self._quickest_ns, took_ns
            self._round_ns = now_ns
            if self.slow:
                self._limit = LEAST
        self._quickest_ns = min(self._quickest_ns, took_ns)
        return min(self._quickest_ns, self._quickest_before_ns)
