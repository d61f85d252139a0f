"""Error queues, as recvmsg(MSG_ERRQUEUE) reads them; that of CAN_RAW contains the times at which frames were sent.

Source: linux/errqueue.h, Linux' Documentation/networking/timestamping.rst, net/core/sock.c (sock_recv_errqueue).
"""

from __future__ import annotations

import errno
import struct
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from canwire.socketcan.constants import SOL_CAN_RAW

if TYPE_CHECKING:
    from canwire.socketcan.table import Stamps

SOL_SOCKET = 1
_CMSG = struct.Struct("<Qii")
_MOST = 1024
_EXTENDED = struct.Struct("<IBBBBII")  # struct sock_extended_err
_ORIGIN_STAMPS = 4  # SO_EE_ORIGIN_TIMESTAMPING
_SENT, _SCHEDULED = 0, 1  # SCM_TSTAMP_
TX_HARDWARE, TX_SOFTWARE, TX_SCHEDULED = 1 << 0, 1 << 1, 1 << 8  # SOF_TIMESTAMPING_
TX = TX_HARDWARE | TX_SOFTWARE | TX_SCHEDULED
_SOFTWARE, _RAW_HARDWARE, _ID, _STAMPS_ONLY = 1 << 4, 1 << 6, 1 << 7, 1 << 11
_RAW_ERROR_QUEUE = 1  # SCM_CAN_RAW_ERRQUEUE


class Queued(NamedTuple):
    """An entry: its data and its control messages, in the form for the program's memory."""

    data: bytes
    control: bytes


class ErrorQueue:
    """The error queue of one socket."""

    def __init__(self) -> None:
        self._entries: deque[Queued] = deque()

    def __len__(self) -> int:
        return len(self._entries)

    def keep(self, entry: Queued) -> bool:
        """Add an entry; False if the queue is full."""
        if len(self._entries) >= _MOST:
            return False
        self._entries.append(entry)
        return True

    def take(self) -> Queued | None:
        """Remove and return the oldest entry."""
        return self._entries.popleft() if self._entries else None

    def clear(self) -> None:
        self._entries.clear()


class TransmitStamps(ErrorQueue):
    """The times when frames of CAN_RAW were accepted and on the bus; `stamps` returns which are wanted."""

    def __init__(self, stamps: Callable[[], Stamps]) -> None:
        super().__init__()
        self._stamps = stamps
        self._next_key = 0
        self._keys: deque[int] = deque()  # of frames on their way, in the order in which they come back

    def begin(self) -> None:
        """SO_TIMESTAMPING was set: if it requests keys, they count from 0."""
        if not self._stamps().flags & _ID:
            self._next_key = 0

    def leaving(self, frames: list[bytes], now_ns: int) -> None:
        """Note that these frames were passed to the line."""
        stamps = self._stamps()
        for frame in frames:
            key = 0
            if stamps.flags & _ID:
                key, self._next_key = self._next_key, self._next_key + 1
            self._keys.append(key)
            if stamps.flags & TX_SCHEDULED:
                self._put(frame, stamps, now_ns, _SCHEDULED, key, _SOFTWARE)

    def sent(self, frame: bytes, stamp_ns: int) -> None:
        """Note that this frame was on the bus."""
        stamps, key = self._stamps(), self._keys.popleft() if self._keys else 0
        if stamps.flags & TX_SOFTWARE:
            self._put(frame, stamps, stamp_ns, _SENT, key, _SOFTWARE)
        if stamps.flags & TX_HARDWARE:
            self._put(frame, stamps, stamp_ns, _SENT, key, _RAW_HARDWARE)

    def gone(self) -> None:
        """No frame that is on its way will come back."""
        self._keys.clear()

    def _put(self, frame: bytes, stamps: Stamps, stamp_ns: int, what: int, key: int, clock: int) -> None:
        control = b""
        if stamps.flags & clock:
            time, none = struct.pack("<qq", *divmod(stamp_ns, 1_000_000_000)), bytes(16)
            places = (time, none, none) if clock == _SOFTWARE else (none, none, time)
            control = control_message(SOL_SOCKET, stamps.stamping, b"".join(places))
        error = _EXTENDED.pack(errno.ENOMSG, _ORIGIN_STAMPS, 0, 0, 0, what, key)
        control += control_message(SOL_CAN_RAW, _RAW_ERROR_QUEUE, error)
        self.keep(Queued(b"" if stamps.flags & _STAMPS_ONLY else frame, control))


def control_message(level: int, kind: int, data: bytes) -> bytes:
    """struct cmsghdr, its data, and padding."""
    length = _CMSG.size + len(data)
    return _CMSG.pack(length, level, kind) + data + bytes(-length % 8)
