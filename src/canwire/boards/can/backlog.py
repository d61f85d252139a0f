"""The frames of all prioritised channels of a line, which wait for the line in the order of their priorities."""

from __future__ import annotations

from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from canwire.boards.can.channel import Channel

ROOM = 256  # frames of one channel


class Backlog:
    """One queue for all prioritised channels of a line: the lowest priority number first, equal ones in order."""

    def __init__(self) -> None:
        self._heap: list[tuple[int, int, bytes, Channel]] = []
        self._count = 0
        self._waiting: dict[Channel, int] = {}

    def __len__(self) -> int:
        return len(self._heap)

    def room(self, channel: Channel) -> int:
        """How many more frames of this channel fit."""
        return ROOM - self._waiting.get(channel, 0)

    def push(self, priority: int, record: bytes, channel: Channel) -> None:
        """Add a frame: `priority` is 0..255, the record has 80 bytes."""
        self._count += 1
        self._waiting[channel] = self._waiting.get(channel, 0) + 1
        heappush(self._heap, (priority, self._count, record, channel))

    def front(self) -> tuple[bytes, Channel]:
        """The frame that is sent next, and its channel."""
        _, _, record, channel = self._heap[0]
        return record, channel

    def pop(self) -> None:
        channel = heappop(self._heap)[3]
        self._waiting[channel] -= 1

    def drop(self, channel: Channel) -> int:
        """Discard this channel's frames; returns how many there were."""
        count = self._waiting.pop(channel, 0)
        if count:
            self._heap = [entry for entry in self._heap if entry[3] is not channel]
            heapify(self._heap)
        return count
