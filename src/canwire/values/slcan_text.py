"""Frames and lines in the ASCII protocol of serial CAN adapters (SLCAN, LAWICEL), both directions.

    t10021133           11-bit identifier, length, data
    T0000010021133      29-bit identifier (eight digits)
    r1002   R000001002  remote frame, asking for two bytes
    d1009...   D...     CAN FD without BRS: one hex digit of DLC (CANable's letters, as are the next)
    b1009...   B...     CAN FD with BRS
    t100211334D67       with a time stamp of four digits: milliseconds

A line ends in CR. Hex in either case is read, upper case is written (source: rulings.md 28; reference/can-protocol.md,
appendix).
"""

from __future__ import annotations

from binascii import hexlify

from canwire.values import frame as codec
from canwire.values import hex_text
from canwire.values.arguments import SignatureOf
from canwire.values.checks import instance, octets, whole
from canwire.values.dlc import FD_LENGTHS
from canwire.values.frame import Frame

LONGEST_LINE = 160  # bytes that are kept of one: more than any frame or command has
_LONGEST = LONGEST_LINE
_EXTENDED, _REMOTE, _FD, _BIT_RATE_SWITCH = 1 << 23, 1 << 22, 1 << 10, 1 << 11  # info bits of a record
_DLC_SHIFT = 16
_LARGEST_STANDARD, _LARGEST_EXTENDED = 0x7FF, 0x1FFFFFFF
_LENGTHS = bytes(FD_LENGTHS)


def _prototype(*, fd: bool = False) -> None:
    """The signature of SlcanReader, for help()."""


class SlcanReader:
    """Cuts a stream into lines, whatever its pieces, and makes frames of those that are one.

    `feed` returns a Frame for each line that is one, and the bytes of any other line without its CR (b"" for a bare
    CR). It never raises. It keeps the first LONGEST_LINE + 1 bytes of an unfinished line, so a line that is too long
    is returned longer than any valid one. Line feeds before a line are skipped.
    With `fd` it also knows CANable's letters, and accepts what programs send to such adapters: surplus bits above the
    29 of an identifier, and an FD frame's DLC in two decimal digits. A remote frame without a length requests no data.
    """

    __signature__ = SignatureOf(_prototype)

    def __init__(self, *, fd: bool = False) -> None:
        self.fd = fd
        self.dropped = 0
        self._rest = b""

    def feed(self, data: bytes | bytearray | memoryview) -> list[Frame | bytes]:
        """The frames and lines that these bytes complete."""
        text = self._rest + (data if data.__class__ is bytes else octets("data", data))
        found: list[Frame | bytes] = []
        start = 0
        end = hex_text.line_end(text, 0)
        while end >= 0:
            found.append(self._line(text, start, end))
            start = end + 1
            end = hex_text.line_end(text, start)
        kept = len(text) - start
        if kept > _LONGEST + 1:
            self.dropped += kept - _LONGEST - 1
            kept = _LONGEST + 1
        self._rest = text[start : start + kept]
        return found

    def __repr__(self) -> str:
        return f"<slcan reader, {len(self._rest)} bytes of an unfinished line, {self.dropped} dropped>"

    def clear(self) -> None:
        """Forget an unfinished line."""
        self._rest = b""

    def _line(self, text: bytes, start: int, end: int) -> Frame | bytes:
        while start < end and text[start] == 10:
            start += 1
        frame = self._frame(text, start, end)
        if frame is not None:
            return frame
        return text[start : end if end - start <= _LONGEST else start + _LONGEST + 1]

    def _frame(self, text: bytes, start: int, end: int) -> Frame | None:
        """The frame between these two positions; None if there is none."""
        if start == end:
            return None
        info = self._kind(text[start])
        at = start + 1
        digits = 8 if info & _EXTENDED else 3
        if info == 1 or end - at < digits:
            return None
        identifier = 0
        for k in range(at, at + digits):
            value = hex_text.digit(text[k])
            if value == hex_text.NO_DIGIT:
                return None
            identifier = identifier << 4 | value
        if not info & _EXTENDED:
            if identifier > _LARGEST_STANDARD:
                return None
        elif identifier > _LARGEST_EXTENDED:
            if not self.fd:
                return None
            identifier &= _LARGEST_EXTENDED
        at += digits
        if info & _REMOTE:
            return self._remote(text, at, end, identifier, info)
        if at == end:
            return None
        code = hex_text.digit(text[at])
        at += 1
        if info & _FD:
            if code == hex_text.NO_DIGIT or end - at != 2 * _LENGTHS[code]:
                code = decimal_code(text, at, end, code)
                at += 1
            if code == hex_text.NO_DIGIT:
                return None
        elif code > 8 or end - at != 2 * code:
            return None
        data = hex_text.octets_of(text, at, end)
        if data is None:
            return None
        return codec._restore(identifier, info | code << _DLC_SHIFT, data, 0)

    def _kind(self, letter: int) -> int:
        """Info bits of a record for a letter; 1 for one that means no frame."""
        if letter == 116:  # t
            return 0
        if letter == 84:  # T
            return _EXTENDED
        if letter == 114:  # r
            return _REMOTE
        if letter == 82:  # R
            return _REMOTE | _EXTENDED
        if not self.fd:
            return 1
        if letter == 100:  # d
            return _FD
        if letter == 68:  # D
            return _FD | _EXTENDED
        if letter == 98:  # b
            return _FD | _BIT_RATE_SWITCH
        if letter == 66:  # B
            return _FD | _BIT_RATE_SWITCH | _EXTENDED
        return 1

    def _remote(self, text: bytes, at: int, end: int, identifier: int, info: int) -> Frame | None:
        code = 0
        if at < end:
            code = hex_text.digit(text[at])
            if code > 8 or at + 1 != end:
                return None
        return codec._restore(identifier, info | code << _DLC_SHIFT, b"", 0)


def decimal_code(text: bytes, at: int, end: int, tens: int) -> int:
    """An FD frame's DLC of two decimal digits, 10..15, whose second one is at `at`; 16 if they are no such DLC."""
    if tens != 1 or at == end or not 48 <= text[at] <= 53:
        return hex_text.NO_DIGIT
    code = text[at] - 38
    return code if end - at - 1 == 2 * _LENGTHS[code] else hex_text.NO_DIGIT


def parse_slcan_frame(line: bytes, *, fd: bool = False) -> Frame | None:
    """The frame in a line without its CR; None if the line has none."""
    text = octets("line", line)
    return SlcanReader(fd=fd)._frame(text, 0, len(text))


def format_slcan_frame(frame: Frame, stamp: int = -1) -> bytes:
    """The line, CR included; with a `stamp` (0..0xFFFF) after the data if that is not -1. Raises BadValue."""
    if frame.__class__ is not Frame:
        instance("frame", frame, Frame)
    if stamp != -1 and not 0 <= stamp <= 0xFFFF:
        whole("stamp", stamp, 0, 0xFFFF)
    info = frame._info
    code = info >> _DLC_SHIFT & 15
    if info & _FD:
        letter = 98 if info & _BIT_RATE_SWITCH else 100
    else:
        letter = 114 if info & _REMOTE else 116
        if code > 8:
            code = 8
    if info & _EXTENDED:
        head = b"%c%08X%X" % (letter - 32, frame._id, code)
    else:
        head = b"%c%03X%X" % (letter, frame._id, code)
    if frame._data:
        head += hexlify(frame._data).upper()
    return head + b"\r" if stamp < 0 else head + b"%04X\r" % stamp
