"""What waits for a program: messages that its socket has no room for yet, up to a limit, then counted as lost."""

from __future__ import annotations

import time
from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import socket
    from collections.abc import Callable

    import numpy

    from canwire.socketcan.rings import RingPair

    Array = numpy.ndarray

BYTES_EACH = 52  # of SO_RCVBUF: the default makes 4096 frames
CONGESTED = 1024  # waiting frames for which a hub in fast time is held up
PATIENCE_S = 0.2  # which so long at most; a program that reads nothing is waited for once


class RowOutlet:
    """Rows of `received_dtype` for one socket: what does not fit into its ring."""

    def __init__(self, ring: RingPair, buffer: Callable[[], int]) -> None:
        self.drops = 0
        self._ring = ring
        self._buffer = buffer
        self._rows: deque[Array] = deque()
        self._waiting = 0
        self._congested_since_s = 0.0
        self._given_up = False

    @property
    def waiting(self) -> int:
        return self._waiting

    def put(self, rows: Array) -> None:
        """Let the program have them, or keep what does not fit."""
        if self._rows:
            room = max(0, max(16, self._buffer() // BYTES_EACH) - self._waiting)
            if len(rows) > room:
                self.drops += len(rows) - room
                rows = rows[:room]
        if self.drops:
            rows["drops"] = self.drops
        if len(rows):
            self._rows.append(rows)
            self._waiting += len(rows)
            self.flush()

    def flush(self) -> None:
        """Hand over what there is room for; the program tells when there is room for the rest."""
        while self._rows:
            rows = self._rows[0]
            done = self._ring.publish(rows)
            if done:
                self._waiting -= done
                self._given_up = False
                self._congested_since_s = 0.0
            if done == len(rows):
                self._rows.popleft()
            else:
                self._rows[0] = rows[done:]
                if self._ring.want_room():
                    return

    def congested(self) -> bool:
        """So much waits that the bus should; no longer once the program has not read for too long."""
        if self._waiting < CONGESTED or self._given_up:
            return False
        now_s = time.monotonic()
        if self._congested_since_s == 0.0:
            self._congested_since_s = now_s
        self._given_up = now_s - self._congested_since_s > PATIENCE_S
        return not self._given_up


class MessageOutlet:
    """Messages of any length for one socket: what BCM and ISO-TP tell."""

    LIMIT = 4096

    def __init__(self, end: socket.socket) -> None:
        self.drops = 0
        self._end = end
        self._messages: deque[bytes] = deque()

    @property
    def waiting(self) -> int:
        return len(self._messages)

    def put(self, message: bytes) -> None:
        """Send it or keep it. Raises OSError once the other end is closed."""
        if len(self._messages) >= self.LIMIT:
            self.drops += 1
            return
        self._messages.append(message)
        self.flush()

    def flush(self) -> None:
        """Send what there is room for. Raises OSError once the other end is closed."""
        while self._messages:
            try:
                self._end.send(self._messages[0])
            except BlockingIOError:
                return
            self._messages.popleft()
