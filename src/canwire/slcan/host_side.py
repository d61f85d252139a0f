"""Output to the host: one bounded buffer for replies and frames, and the queue of frames before it."""

from __future__ import annotations

from collections import deque

from canwire import Frame, format_slcan_frame
from canwire.slcan.settings import DongleCounters

RECEIVE_QUEUE = 32  # frames (source: CANBUS manual, 1.3)
STAMP_PERIOD_MS = 60_000  # 0000..EA5F
_FOR_REPLIES = 1024  # bytes that frames leave free
_LONGEST_FRAME = 160


class HostSide:
    """`output` waits for the host. Frames that do not fit into it wait in `queue`. If the host reads nothing, the 33rd
    of these frames is lost, and replies that do not fit, too: no method blocks, and each loss is counted."""

    def __init__(self, size: int, counters: DongleCounters, origin_ns: int) -> None:
        self.output = bytearray()
        self.queue: deque[Frame] = deque()
        self.stamps = False
        self._size = size
        self._counters = counters
        self._origin_ns = origin_ns

    def tell(self, reply: bytes) -> None:
        if len(self.output) + len(reply) <= self._size:
            self.output += reply
        else:
            self._counters.replies_lost += 1

    def take(self, frame: Frame) -> bool:
        """Accept a received frame; False if it is lost."""
        if not self.queue and self._has_room():
            self._pass_on(frame)
        elif len(self.queue) < RECEIVE_QUEUE:
            self.queue.append(frame)
        else:
            return False
        return True

    def written(self, count: int) -> None:
        del self.output[:count]
        while self.queue and self._has_room():
            self._pass_on(self.queue.popleft())

    def clear(self) -> None:
        """Discard everything: the host is gone."""
        self.output.clear()
        self.queue.clear()

    def _has_room(self) -> bool:
        return len(self.output) + _LONGEST_FRAME <= self._size - _FOR_REPLIES

    def _pass_on(self, frame: Frame) -> None:
        stamp = -1
        if self.stamps:
            stamp = max(0, frame.timestamp_ns - self._origin_ns) // 1_000_000 % STAMP_PERIOD_MS
        self.output += format_slcan_frame(frame, stamp)
        self._counters.received += 1
