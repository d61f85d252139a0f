"""What two ends of a relay say to each other, without I/O: many TCP connections in one, compressed together.

    first line   "canwire relay 1", from the hub's end also realm and name of the hub, ended by a line feed
    then         messages in one raw deflate stream, which is flushed after each:
                 1 byte kind, 2 bytes number of the connection, 2 bytes size, data; numbers are little-endian

Programs of one machine that read the same line receive the same packed frames at nearly the same time, so deflate
finds what one of them gets in what another one got less than 32 kB before.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import NamedTuple

from canwire.errors import BadMessage

OPEN, DATA, CLOSE, ALIVE = 1, 2, 3, 4
LARGEST = (1 << 16) - 1  # bytes of one message
GREETING = b"canwire relay 1"
LONGEST_GREETING = 256
_HEAD = struct.Struct("<BHH")
_LEVEL = 6
_AT_A_TIME = 1 << 16  # bytes of what was compressed that are expanded before they are looked at


class Said(NamedTuple):
    """A message: its kind, the connection's number (ALIVE: 0), and the data of DATA."""

    kind: int
    number: int
    data: bytes = b""


class Encoder:
    """Makes bytes of messages, each of which the other end can read as soon as it has them."""

    def __init__(self) -> None:
        self._deflate = zlib.compressobj(_LEVEL, zlib.DEFLATED, -zlib.MAX_WBITS, 9)

    def encode(self, said: Said) -> bytes:
        """Data of up to LARGEST bytes."""
        head = _HEAD.pack(said.kind, said.number, len(said.data))
        return self._deflate.compress(head + said.data) + self._deflate.flush(zlib.Z_SYNC_FLUSH)


class Decoder:
    """Makes messages of bytes, however they are cut."""

    def __init__(self) -> None:
        self._inflate = zlib.decompressobj(-zlib.MAX_WBITS)
        self._rest = bytearray()

    def take(self, data: bytes) -> Iterator[Said]:
        """The messages that are whole; raises BadMessage. A few bytes that mean gigabytes take no more memory."""
        while data:
            try:
                self._rest += self._inflate.decompress(data, _AT_A_TIME)
            except zlib.error as error:
                raise BadMessage(f"a relay sent what is not compressed: {error}") from None
            if self._inflate.eof:
                raise BadMessage("a relay ended its compressed stream, which lasts as long as its connection")
            data = self._inflate.unconsumed_tail
            yield from self._whole()

    def _whole(self) -> Iterator[Said]:
        at = 0
        while len(self._rest) - at >= _HEAD.size:
            kind, number, size = _HEAD.unpack_from(self._rest, at)
            if not OPEN <= kind <= ALIVE or (size and kind != DATA):
                raise BadMessage(f"a relay sent a message of kind {kind} with {size} bytes")
            end = at + _HEAD.size + size
            if end > len(self._rest):
                break
            yield Said(kind, number, bytes(self._rest[end - size : end]))
            at = end
        del self._rest[:at]
