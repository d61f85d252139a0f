"""The server's ends of the rings that CAN sockets share with it; shim/ring.h describes them."""

from __future__ import annotations

import ctypes
import errno
import mmap
import os
import struct
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from canwire.socketcan.table import MOST_SLOTS
from canwire.socketcan.wire import HEADER_SIZE, numpy_module, sent_dtype

if TYPE_CHECKING:
    import numpy

    Array = numpy.ndarray

_HEADER = struct.Struct("<QIiHHI")  # shim/shim.h, struct received
_ABOUT_SIZE = 24  # shim/shim.h, struct about
COLLECTED = 512  # rows in one call


def has_room(directory: str, size: int) -> bool:
    """True if this many bytes are free: a program that writes into a mapped file without free space is killed."""
    there = os.statvfs(directory)
    return there.f_bavail * there.f_frsize >= size


class Row(NamedTuple):
    """The data that accompanies a message; `about`: the addresses of a J1939 message, else zeros."""

    stamp_ns: int
    drops: int
    interface: int
    flags: int
    error: int
    length: int
    about: bytes


class Rings:
    """All rings of one server, in a file at `path`, by the shared object `library`."""

    def __init__(self, path: str, library: str) -> None:
        self.library = _library(library)
        self._size = int(self.library.canwire_block_size())
        self.directory = os.path.dirname(path)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            os.ftruncate(descriptor, self._size * MOST_SLOTS)
            self._memory = mmap.mmap(descriptor, self._size * MOST_SLOTS)
        finally:
            os.close(descriptor)
        self._address = ctypes.addressof(ctypes.c_char.from_buffer(self._memory))

    @cached_property
    def rows(self) -> Array:
        """The rows collected last. Made for the first socket, because loading numpy takes long."""
        found: Array = numpy_module().zeros(COLLECTED, sent_dtype())
        return found

    @cached_property
    def rows_address(self) -> int:
        return int(self.rows.ctypes.data)

    def pair(self, slot: int, descriptor: int) -> RingPair:
        """New rings for this slot; `descriptor` is the server's end of its socket pair. Raises OSError: ENOSPC."""
        if not has_room(self.directory, self._size):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), self.directory)
        return RingPair(self, self._address + slot * self._size, descriptor)


class RingPair:
    """The rings of one socket: messages and rows of `received_dtype` to it, rows of `sent_dtype` from it."""

    def __init__(self, rings: Rings, address: int, descriptor: int) -> None:
        self._rings = rings
        self._library = rings.library
        self._block = ctypes.c_void_p(address)
        self._descriptor = descriptor
        self._library.canwire_prepare(self._block)

    def publish(self, rows: Array) -> int:
        """Send the frames of these contiguous rows; returns how many rows had room."""
        return int(self._library.canwire_publish(self._block, rows.ctypes.data, len(rows), self._descriptor))

    def collect(self, limit: int) -> Array:
        """The program's rows, valid until the next call for any socket; their `size` is what the program wrote."""
        count = self._library.canwire_collect(self._block, self._rings.rows_address, min(limit, COLLECTED))
        return self._rings.rows[:count]

    def row_of_message(self, data: bytes, peeks: bool) -> Row:
        """The Row of the oldest message, which has these bytes; zeros if there is none."""
        room, about = ctypes.create_string_buffer(HEADER_SIZE), ctypes.create_string_buffer(_ABOUT_SIZE)
        if not self._library.canwire_take_row(self._block, data, len(data), int(peeks), room, about):
            return Row(0, 0, 0, 0, 0, len(data), about.raw)
        stamp_ns, drops, interface, flags, error, length = _HEADER.unpack(room.raw)
        return Row(stamp_ns, drops, interface, flags, error, length, about.raw)

    def publish_message(self, message: bytes, about: bytes) -> bool:
        """Send a header and a payload of any length; False if there is no room."""
        header, payload = message[:HEADER_SIZE], message[HEADER_SIZE:]
        about = about.ljust(_ABOUT_SIZE, b"\0")
        published = self._library.canwire_publish_message(
            self._block, header, payload, about, self._descriptor
        )
        return bool(published)

    def want_frames(self) -> bool:
        """Request a byte on the socket with the next frame; False if there is already a frame."""
        return bool(self._library.canwire_want_frames(self._block))


def _library(path: str) -> Any:
    library = ctypes.CDLL(path)
    pointer, number, long = ctypes.c_void_p, ctypes.c_int, ctypes.c_long
    signatures: dict[str, tuple[Any, list[Any]]] = {
        "canwire_block_size": (ctypes.c_ulong, []),
        "canwire_prepare": (None, [pointer]),
        "canwire_publish": (long, [pointer, pointer, long, number]),
        "canwire_collect": (long, [pointer, pointer, long]),
        "canwire_take_row": (
            number,
            [pointer, ctypes.c_char_p, ctypes.c_ulong, number, ctypes.c_char_p, ctypes.c_char_p],
        ),
        "canwire_publish_message": (
            number,
            [pointer, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p, number],
        ),
        "canwire_want_frames": (number, [pointer]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library
