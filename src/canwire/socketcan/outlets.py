"""Messages that wait until a program's socket has room for them, up to a limit; further ones are counted as lost."""

from __future__ import annotations

import fcntl
import socket
import struct
import termios
import time
from collections import deque
from functools import cache
from typing import TYPE_CHECKING

from canwire.socketcan.table import USUAL_RECEIVE_BUFFER

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy

    from canwire.socketcan.rings import RingPair

    Array = numpy.ndarray

USUAL_LIMIT = 4096  # frames, where a program has not set SO_RCVBUF: a hub in fast time is quicker than a wire
BYTES_EACH = 768  # of SO_RCVBUF that has been set: what a frame takes in a kernel of 64 bits
MOST_IN_PAIR = 512  # frames: a kernel's usual limit; fewer than half the rows beside them (shim/ring.h)
CONGESTED = 1024  # waiting frames for which a hub in fast time is held up
PATIENCE_S = 0.2  # which so long at most; a program that reads nothing is waited for once


class RowOutlet:
    """Rows of `received_dtype` for one socket that its socket pair has no room for."""

    def __init__(self, ring: RingPair, end: socket.socket, buffer: Callable[[], int]) -> None:
        self.drops = 0
        self._ring = ring
        self._end = end
        self._buffer = buffer
        self._bytes = -1  # of SO_RCVBUF, as it was looked at last
        self._limit = USUAL_LIMIT
        self._rows: deque[Array] = deque()
        self._waiting = 0
        self._congested_since_s = 0.0
        self._given_up = False

    @property
    def waiting(self) -> int:
        return self._waiting

    def put(self, rows: Array) -> None:
        """Pass rows to the program, and keep those that do not fit."""
        if self._buffer() != self._bytes:
            self._set_limit(self._buffer())
        if self._rows:
            room = max(0, self._limit - self._waiting)
            if len(rows) > room:
                self.drops += len(rows) - room
                rows = rows[:room]
        if self.drops:
            rows["drops"] = self.drops
        if len(rows):
            self._rows.append(rows)
            self._waiting += len(rows)
            self.flush()
            self._lose_too_many()

    def _set_limit(self, size: int) -> None:
        """Frames in the pair, and frames here: together what a kernel's socket with such an SO_RCVBUF keeps."""
        self._bytes = size
        whole = -(-size // BYTES_EACH) if size != USUAL_RECEIVE_BUFFER else USUAL_LIMIT
        in_pair = min(whole, MOST_IN_PAIR)
        self._end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, in_pair * _message_size() // 2)
        there: int = self._end.getsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF)
        self._limit = max(0, whole - there // _message_size())

    def _lose_too_many(self) -> None:
        """Count and drop the rows for which neither the pair nor the limit has room."""
        lost = self._waiting - self._limit
        if lost > 0:  # of the newest ones, which came last
            rows = self._rows.pop()
            if lost < len(rows):
                self._rows.append(rows[:-lost])
            self._waiting -= lost
            self.drops += lost

    def flush(self) -> None:
        """Pass on as many rows as fit; the descriptor signals when there is room for the rest."""
        while self._rows:
            rows = self._rows[0]
            done = self._ring.publish(rows)
            if done:
                self._waiting -= done
                self._given_up = False
                self._congested_since_s = 0.0
            if done < len(rows):
                self._rows[0] = rows[done:]
                return
            self._rows.popleft()

    def congested(self) -> bool:
        """True if so many rows wait that the bus should wait, too; False if the program has not read for too long."""
        if self._waiting < CONGESTED or self._given_up:
            return False
        now_s = time.monotonic()
        if self._congested_since_s == 0.0:
            self._congested_since_s = now_s
        self._given_up = now_s - self._congested_since_s > PATIENCE_S
        return not self._given_up


class MessageOutlet:
    """Messages of any length for one socket, from BCM and ISO-TP."""

    LIMIT = 4096

    def __init__(self, ring: RingPair) -> None:
        self.drops = 0
        self._ring = ring
        self._messages: deque[tuple[bytes, bytes]] = deque()

    @property
    def waiting(self) -> int:
        return len(self._messages)

    def put(self, message: bytes, about: bytes = b"") -> None:
        """Send or keep a message; `about`: the addresses of a J1939 message."""
        if len(self._messages) >= self.LIMIT:
            self.drops += 1
            return
        self._messages.append((message, about))
        self.flush()

    def flush(self) -> None:
        """Send as many messages as fit."""
        while self._messages and self._ring.publish_message(*self._messages[0]):
            self._messages.popleft()


@cache
def _message_size() -> int:
    """Bytes that this kernel counts for a frame that waits in a pair."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with ours, theirs:
        ours.send(bytes(16))
        found: int = struct.unpack("i", fcntl.ioctl(ours, termios.TIOCOUTQ, bytes(4)))[0]
    return found
