# cython: nonecheck=False
"""Reads a frame bit by bit, as every controller on the bus does, its own sender included.

From SOF to the last CRC bit: destuffing, fields, CRC 15/17/21. station.py handles what comes after
(delimiters, ACK, EOF), and the consequences of errors.
Source: ISO 11898-1:2015 chapter 10.4; reference/can-protocol.md sections 1 to 4.
"""

from __future__ import annotations

from array import array

from canwire import _mem
from canwire.bus.can.bits import (
    CRC15_POLY,
    CRC17_ISO_START,
    CRC17_POLY,
    CRC21_ISO_START,
    CRC21_POLY,
    NON_ISO,
    STUFF_COUNT_CODE,
)
from canwire.bus.can.node import Node
from canwire.values.dlc import FD_LENGTHS

# fields of a frame, in the order of the wire
(
    SOF, BASE, RTR, IDE, EXT, RTR2, FDF, R0, RES, BRS, ESI, DLC, DATA,
    FD_CRC, CRC, CRC_DELIMITER, ACK, ACK_DELIMITER, EOF,
) = range(19)  # fmt: skip
(
    _SOF, _BASE, _RTR, _IDE, _EXT, _RTR2, _FDF, _R0, _RES, _BRS, _ESI, _DLC, _DATA,
    _FD_CRC, _CRC, _CRC_DELIMITER,
) = range(16)  # fmt: skip

# results of one bit
TAKEN, STUFF_ERROR, FORM_ERROR, PROTOCOL_EXCEPTION, FAST_FROM_HERE = range(5)
_TAKEN, _STUFF_ERROR, _FORM_ERROR, _PROTOCOL_EXCEPTION, _FAST_FROM_HERE = range(5)

_NON_ISO = NON_ISO
_CRC15_POLY, _CRC17_POLY, _CRC21_POLY = CRC15_POLY, CRC17_POLY, CRC21_POLY
_CRC17_START, _CRC21_START = CRC17_ISO_START, CRC21_ISO_START
_TABLES = array("H", [*FD_LENGTHS, *STUFF_COUNT_CODE])
_LENGTHS = _mem.shorts_of(_TABLES)  # and behind the 16 of them the codes of stuff counts
_CODES = 16
_WORDS = 8  # of the longest payload


class FrameReader:
    """Reads one frame after another; `begin` must be called before each.

    `fd_mode` is Node.fd: a classic reader reads FDF as the reserved bit r0, unless `protocol_exception` is set. `field`
    is the field of the next bit, unless that is a stuff bit; `left` is the number of its bits still to come, and
    `value` the bits read so far (in the data field, those of the present byte; `payload` holds the bytes before it, as
    in a record).
    """

    def __cinit__(self, *_: object) -> None:
        """Compiled: a reader that was never initialised has memory for a payload, too."""
        self._take_memory()

    def __init__(self, fd_mode: int) -> None:
        self.fd_mode = fd_mode
        self.protocol_exception = fd_mode != 0
        self._take_memory()
        self.length = self.crc_width = self.crc_position = 0
        self.begin()

    def _take_memory(self) -> None:
        self._block = bytearray(8 * _WORDS)
        self.payload = _mem.words_of(self._block)

    def begin_for(self, node: Node) -> None:
        """Start a frame for this node: the next bit is an SOF."""
        self.fd_mode = node.fd
        self.protocol_exception = node.protocol_exception
        self.begin()

    def begin(self) -> None:
        """Start a frame: the next bit is an SOF."""
        self.field = _SOF
        self.left = 1
        self.value = 0
        self.same = 0
        self.last = 1
        self.stuffing = True
        self.stuff_count = 0
        iso = self.fd_mode != _NON_ISO
        self.crc15 = 0
        self.crc17 = _CRC17_START if iso else 0
        self.crc21 = _CRC21_START if iso else 0
        self.identifier = 0
        self.extended = self.remote = self.fd = self.switch = self.esi = False
        self.dlc = self.length = 0
        self.crc_ok = False

    def expects_stuff_bit(self) -> bool:
        return self.stuffing and self.same == 5

    def go_on(self, field: int, bits: int) -> None:
        """Begin this field, which has the next `bits` bits."""
        self.field = field
        self.left = bits
        self.value = 0

    def take(self, level: int) -> int:
        """Read one bit; returns its result (TAKEN, STUFF_ERROR ...)."""
        if self.stuffing:
            if self.same == 5:
                return self._stuff_bit(level)
            self.same = self.same + 1 if level == self.last and self.same else 1
        field = self.field
        if field <= _DATA:
            self._cover(level)
            if not self.fd:
                self.crc15 = _shift(self.crc15, level, 15, _CRC15_POLY)
        previous = self.last
        self.last = level
        if field == _FD_CRC:
            return self._fd_crc_bit(level, previous)
        self.value = self.value << 1 | level
        self.left -= 1
        if field == _DATA:
            self._data_bit()
        elif self.left == 0 and field < _CRC_DELIMITER:
            return self._field_done(self.value)
        return _TAKEN

    def take_run(self, levels: bytes, first: int, most: int) -> int:
        """Read up to `most` bits of `levels` from `first` on; returns how many, up to a result other than TAKEN or the
        tail.
        """
        for k in range(first, first + most):
            if self.field >= _CRC_DELIMITER and not self.stuffing:
                return k - first
            if self.take(levels[k]) != _TAKEN:
                return k - first
        return most

    def take_steady(self, level: int, most: int) -> int:
        """Read up to `most` bits of one level; returns how many, up to a result other than TAKEN or the tail."""
        for k in range(most):
            if self.field >= _CRC_DELIMITER and not self.stuffing:
                return k
            if self.take(level) != _TAKEN:
                return k
        return most

    def _cover(self, level: int) -> None:
        """Update CRC-17 and CRC-21, unless the frame is known to be a classic one."""
        if self.fd or self.field <= _FDF:
            self.crc17 = _shift(self.crc17, level, 17, _CRC17_POLY)
            self.crc21 = _shift(self.crc21, level, 21, _CRC21_POLY)

    def _data_bit(self) -> None:
        if self.left % 8:
            return
        at = self.length - 1 - self.left // 8
        byte = self.value
        if at % 8:
            self.payload[at // 8] |= byte << at % 8 * 8
        else:
            self.payload[at // 8] = byte
        self.value = 0
        if self.left == 0:
            self._begin_crc()

    def _stuff_bit(self, level: int) -> int:
        if level == self.last:
            return _STUFF_ERROR
        self.last = level
        self.same = 1
        self.stuff_count += 1
        if self.field <= _DATA:
            self._cover(level)
        if self.field == _CRC_DELIMITER:
            self.stuffing = False
            self.same = 0
        return _TAKEN

    def _field_done(self, value: int) -> int:
        field = self.field
        if field == _SOF:
            self.go_on(_BASE, 11)
        elif field == _BASE:
            self.identifier = value
            self.go_on(_RTR, 1)
        elif field == _RTR:
            self.remote = value == 1
            self.go_on(_IDE, 1)
        elif field == _IDE:
            self.extended = value == 1
            self.go_on(_EXT if value else _FDF, 18 if value else 1)
        elif field == _EXT:
            self.identifier = self.identifier << 18 | value
            self.go_on(_RTR2, 1)
        elif field == _RTR2:
            self.remote = value == 1
            self.go_on(_FDF, 1)
        else:
            return self._control_done(field, value)
        return _TAKEN

    def _control_done(self, field: int, value: int) -> int:
        if field == _FDF:
            self.fd = value == 1 and self.fd_mode != 0
            if value == 1 and self.fd_mode == 0 and self.protocol_exception:
                return _PROTOCOL_EXCEPTION
            if self.fd:
                self.remote = False
                self.go_on(_RES, 1)
            else:
                self.go_on(_R0 if self.extended else _DLC, 1 if self.extended else 4)
        elif field == _R0:
            self.go_on(_DLC, 4)
        elif field == _RES:
            if value:
                return _PROTOCOL_EXCEPTION if self.protocol_exception else _FORM_ERROR
            self.go_on(_BRS, 1)
        elif field == _BRS:
            self.switch = value == 1
            self.go_on(_ESI, 1)
            return _FAST_FROM_HERE if self.switch else _TAKEN
        elif field == _ESI:
            self.esi = value == 1
            self.go_on(_DLC, 4)
        else:
            self._body_done(field, value)
        return _TAKEN

    def _body_done(self, field: int, value: int) -> None:
        if field == _DLC:
            self.dlc = value
            length = _LENGTHS[value]
            if not self.fd and length > 8:
                length = 8
            self.length = 0 if self.remote else length
            if self.length:
                self.go_on(_DATA, 8 * self.length)
            else:
                self._begin_crc()
        else:
            self._end_crc(value == self.crc15)
            if self.same != 5:  # else one more stuff bit follows the last CRC bit
                self.stuffing = False
                self.same = 0

    def _end_crc(self, ok: bool) -> None:
        self.crc_ok = ok
        self.crc15 = self.crc17 = self.crc21 = self.crc_position = 0  # all readers of this frame end alike
        self.go_on(_CRC_DELIMITER, 1)

    def _begin_crc(self) -> None:
        if self.fd:
            self.stuffing = False
            self.same = 0
            coded = 4 if self.fd_mode != _NON_ISO else 0
            self.crc_width = 17 if self.length <= 16 else 21
            self.crc_position = 0
            bits = coded + self.crc_width
            self.go_on(_FD_CRC, bits + (bits + 3) // 4)
        else:
            self.go_on(_CRC, 15)

    def _fd_crc_bit(self, level: int, previous: int) -> int:
        """Read a bit of the FD CRC; a fixed stuff bit before every group of four bits is the inverse of the bit before
        it.
        """
        if self.crc_position % 5 == 0:
            if level == previous:
                return _FORM_ERROR
        else:
            self.value = self.value << 1 | level
            if self.fd_mode != _NON_ISO and self.crc_position < 5:
                self._cover(level)
        self.crc_position += 1
        self.left -= 1
        if self.left == 0:
            received = self.value & (1 << self.crc_width) - 1
            code = self.value >> self.crc_width
            counted = self.fd_mode == _NON_ISO or code == _LENGTHS[_CODES + (self.stuff_count & 7)]
            self._end_crc(counted and received == (self.crc17 if self.crc_width == 17 else self.crc21))
        return _TAKEN


def _shift(register: int, bit: int, width: int, poly: int) -> int:
    fed_back = bit ^ register >> (width - 1)
    register = register << 1 & ((1 << width) - 1)
    return register ^ poly if fed_back else register
