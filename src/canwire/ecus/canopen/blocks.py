"""Block transfers of an SDO server, which canopen's lacks: both directions, with CRC and repeated segments.

Source: CiA 301 4.2.0, 7.2.4.3.9 to 7.2.4.3.16.
"""

from __future__ import annotations

from binascii import crc_hqx
from collections.abc import Callable
from typing import Any

from canopen import SdoAbortedError

_SEGMENT = 7  # bytes
_MOST = 127  # segments in a block
_CRC, _SIZE, _LAST = 0x04, 0x02, 0x80
_UPLOAD, _DOWNLOAD = 0xC0, 0xA0  # the server's answers begin with these bits
_RESPONSE, _END = 0x02, 0x01
_NO_COMMAND, _BAD_BLOCK_SIZE, _BAD_SEQUENCE = 0x05040001, 0x05040002, 0x05040003
_BAD_CRC, _TOO_LONG, _TOO_SHORT, _NO_DATA = 0x05040004, 0x06070012, 0x06070013, 0x08000024

Send = Callable[[bytes], object]


class BlockUpload:
    """The client reads `data`: it requested blocks of `size` segments, and starts the transfer.

    `take(request)` is True once the transfer is over.
    """

    def __init__(self, data: bytes, object_bytes: bytes, size: int, crc: bool, send: Send) -> None:
        if not data:
            raise SdoAbortedError(_NO_DATA)
        self._check(size)
        self._data, self._size, self._send = data, size, send
        self._crc = crc_hqx(data, 0) if crc else 0
        self._place = 0  # of the first byte that is not acknowledged
        self._segments = 0  # of the block under way
        send(bytes([_UPLOAD | _CRC | _SIZE]) + object_bytes + len(data).to_bytes(4, "little"))

    def take(self, request: bytes) -> bool:
        """Handle a request: the start, an acknowledged block, or the end. Returns True once the transfer is over."""
        command = request[0] & 0x03
        if command == 0x03:
            self._block()
        elif command == _RESPONSE:
            self._acknowledged(request[1], request[2])
        elif command == _END:
            return True
        else:
            raise SdoAbortedError(_NO_COMMAND)
        return False

    def _acknowledged(self, number: int, size: int) -> None:
        """Handle the client's receipt of the segments up to `number`; later segments are sent again."""
        if number > self._segments:
            raise SdoAbortedError(_BAD_SEQUENCE)
        self._check(size)
        self._place += number * _SEGMENT
        self._size = size
        if self._place < len(self._data):
            self._block()
        else:
            unused = -len(self._data) % _SEGMENT
            head = bytes([_UPLOAD | unused << 2 | _END])
            self._send(head + self._crc.to_bytes(2, "little") + bytes(5))

    def _block(self) -> None:
        self._segments = 0
        for start in range(self._place, len(self._data), _SEGMENT)[: self._size]:
            self._segments += 1
            segment = self._data[start : start + _SEGMENT]
            last = _LAST if start + _SEGMENT >= len(self._data) else 0
            self._send(bytes([self._segments | last]) + segment.ljust(_SEGMENT, b"\0"))

    @staticmethod
    def _check(size: int) -> None:
        if not 1 <= size <= _MOST:
            raise SdoAbortedError(_BAD_BLOCK_SIZE)


class BlockDownload:
    """The client writes: `done(data)` gets all of it. `size` is the announced size, or None.

    `take(request)` is True once the transfer is over.
    """

    def __init__(
        self, object_bytes: bytes, size: int | None, crc: bool, send: Send, done: Callable[[bytes], Any]
    ) -> None:
        self._wanted, self._crc, self._send, self._done = size, crc, send, done
        self._data = bytearray()
        self._number = 0  # of the last segment that came in its turn
        self._whole = False
        send(bytes([_DOWNLOAD | _CRC]) + object_bytes + bytes([_MOST, 0, 0, 0]))

    def take(self, request: bytes) -> bool:
        """Handle a segment, or the end after the last segment. Returns True once the transfer is over."""
        if self._whole:
            return self._ended(request)
        number = request[0] & 0x7F
        if number == self._number + 1:
            self._number = number
            self._data += request[1:8]
            self._whole = bool(request[0] & _LAST)
        if number == _MOST or request[0] & _LAST:
            self._send(bytes([_DOWNLOAD | _RESPONSE, self._number, _MOST]) + bytes(5))
            self._number = 0
        return False

    def _ended(self, request: bytes) -> bool:
        if request[0] & 0xE3 != 0xC1:
            raise SdoAbortedError(_NO_COMMAND)
        unused = request[0] >> 2 & 7
        data = bytes(self._data[: len(self._data) - unused])
        if self._crc and crc_hqx(data, 0) != int.from_bytes(request[1:3], "little"):
            raise SdoAbortedError(_BAD_CRC)
        if self._wanted is not None and len(data) != self._wanted:
            raise SdoAbortedError(_TOO_LONG if len(data) > self._wanted else _TOO_SHORT)
        self._done(data)
        self._send(bytes([_DOWNLOAD | _END]) + bytes(7))
        return True
