"""A queue for single frames of sockets: they wait here while their line has no room."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from canwire.socketcan.interfaces import FULL
from canwire.socketcan.wire import row_of, sound

if TYPE_CHECKING:
    from canwire.socketcan.port import Port

_MOST_WAITING = 4096


class FrameQueue:
    """A queue for any number of lines."""

    def __init__(self) -> None:
        self._queued: dict[Port, deque[tuple[int, bytes]]] = {}

    def send(self, port: Port, slot: int, frame: bytes) -> None:
        """Send a struct can_frame or canfd_frame of the socket of this slot."""
        waiting = self._queued.setdefault(port, deque())
        if len(waiting) < _MOST_WAITING:
            waiting.append((slot, frame))
        else:
            port.drop(1, FULL)
        if len(waiting) == 1:
            self._drain(port)

    def _drain(self, port: Port) -> None:
        waiting = self._queued.get(port)
        if waiting is None:  # dropped with its interface
            return
        while waiting and port.room():
            slot, frame = waiting.popleft()
            row = row_of(frame, port.interface.index)
            if sound(row).all():
                port.send(slot, row)
        if port.lost:
            port.drop(len(waiting))
            del self._queued[port]
        elif waiting:
            port.when_room(lambda: self._drain(port))
