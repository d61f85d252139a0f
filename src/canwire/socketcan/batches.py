"""Many messages in one system call: recvmmsg and sendmmsg, which Python's socket module does not have."""

from __future__ import annotations

import ctypes
import errno
import os
import struct
from typing import TYPE_CHECKING

from canwire.socketcan.wire import (
    HEADER_SIZE,
    SENT_HEADER_SIZE,
    numpy_module,
    sent_dtype,
)

if TYPE_CHECKING:
    import numpy

    Array = numpy.ndarray

BATCH = 512
_DONT_WAIT, _NO_SIGNAL = 0x40, 0x4000
_VECTOR = [("base", "<u8"), ("size", "<u8")]
_MESSAGE = [
    ("name", "<u8"),
    ("name_length", "<u8"),
    ("vectors", "<u8"),
    ("vector_count", "<u8"),
    ("control", "<u8"),
    ("control_length", "<u8"),
    ("flags", "<u8"),
    ("length", "<u8"),
]  # struct mmsghdr where pointers have 64 bits

LP64 = struct.calcsize("P") == 8
_libc = ctypes.CDLL(None, use_errno=True)


class _Messages:
    """Headers of BATCH messages, one vector each."""

    def __init__(self) -> None:
        numpy = numpy_module()
        self.vectors = numpy.zeros(BATCH, _VECTOR)
        self.headers = numpy.zeros(BATCH, _MESSAGE)
        step = self.vectors.itemsize
        self.headers["vectors"] = self.vectors.ctypes.data + numpy.arange(BATCH, dtype="u8") * step
        self.headers["vector_count"] = 1
        self.address = self.headers.ctypes.data
        self.numbers = numpy.arange(BATCH, dtype="u8")


class BatchSender:
    """Sends rows of `received_dtype`."""

    def __init__(self) -> None:
        self._messages = _Messages()

    def send(self, descriptor: int, rows: Array) -> int:
        """How many of these contiguous rows went out, at most BATCH; 0: there is no room. Raises OSError."""
        count = min(len(rows), BATCH)
        vectors = self._messages.vectors
        vectors["base"][:count] = rows.ctypes.data + self._messages.numbers[:count] * rows.itemsize
        vectors["size"][:count] = rows["length"][:count] + HEADER_SIZE
        done = _libc.sendmmsg(
            descriptor, ctypes.c_void_p(self._messages.address), count, _DONT_WAIT | _NO_SIGNAL
        )
        return _checked(done)


class BatchReceiver:
    """Receives rows of `sent_dtype`."""

    def __init__(self) -> None:
        numpy = numpy_module()
        self._messages = _Messages()
        self._rows = numpy.zeros(BATCH, sent_dtype())
        step = self._rows.itemsize
        self._messages.vectors["base"] = self._rows.ctypes.data + self._messages.numbers * step
        self._messages.vectors["size"] = step

    def receive(self, descriptor: int, limit: int) -> tuple[Array, bool]:
        """Up to `limit` rows, good until the next call, and whether the other end is closed. Raises OSError.

        `size` of a row is that of its frame as it came, whatever the row's header says.
        """
        count = min(limit, BATCH)
        done = _checked(
            _libc.recvmmsg(descriptor, ctypes.c_void_p(self._messages.address), count, _DONT_WAIT, None)
        )
        lengths = (self._messages.headers["length"][:done] & 0xFFFF_FFFF).astype("i8")
        ends = lengths == 0
        rows = self._rows[:done]
        if ended := bool(ends.any()):
            first = int(ends.argmax())
            rows, lengths = rows[:first], lengths[:first]
        rows["size"] = numpy_module().maximum(lengths - SENT_HEADER_SIZE, 0)
        return rows, ended


def _checked(done: int) -> int:
    if done >= 0:
        return int(done)
    error = ctypes.get_errno()
    if error in (errno.EAGAIN, errno.EINTR):
        return 0
    raise OSError(error, os.strerror(error))
