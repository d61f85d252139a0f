"""A frame laid out bit by bit, as its sender drives it: levels, fields, stuff bits, CRC.

The slow, plain equivalent of can_bits.measure: the bit level transmits it, and `canwire bits` draws it.
Source: ISO 11898-1:2015 chapter 10.4; reference/can-protocol.md sections 1 to 4.
"""

from __future__ import annotations

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
from canwire.bus.can.node import Mailbox
from canwire.errors import BadValue
from canwire.values import frame as codec
from canwire.values.arguments import SignatureOf
from canwire.values.checks import instance, shown
from canwire.values.frame import Frame

FIELDS = (
    "SOF", "ID", "RTR", "IDE", "EXT", "RTR2", "FDF", "r0", "res", "BRS", "ESI", "DLC", "DATA",
    "STUFF COUNT", "CRC", "CRC DEL", "ACK", "ACK DEL", "EOF",
)  # the names of a frame's fields, in the order of the wire  # fmt: skip
_INDEX = {name: index for index, name in enumerate(FIELDS)}
(
    _SOF, _ID, _RTR, _IDE, _EXT, _RTR2, _FDF, _R0, _RES, _BRS, _ESI, _DLC, _DATA,
    _STUFF_COUNT, _CRC, _CRC_DEL, _ACK, _ACK_DEL, _EOF,
) = range(19)  # fmt: skip
_EOF_BITS = 7
_TAIL_BITS = 10  # CRC delimiter, ACK slot, ACK delimiter, EOF
_RECORD_WORDS = 10
_MOST_BITS = 800  # 64 bytes, an extended identifier and all the stuff bits there can be


def _prototype(frame: Frame, *, fd_mode: int = 0, error_passive: bool = False) -> None:
    """The signature of BitLayout for help()."""


class BitLayout:
    """Every bit of one frame from SOF to the last EOF bit; the ACK slot is recessive, as a sender drives it.

    `levels`, `fields` (index into FIELDS) and `stuffed` (1 for dynamic and fixed stuff bits) hold one
    byte a bit. `stuff_bits` counts dynamic stuff bits, `data_bits` the bits at the data rate
    from the one after BRS to the last CRC bit, `crc` is the value sent.
    """

    __signature__ = SignatureOf(_prototype)

    def __init__(self, frame: Frame, *, fd_mode: int = 0, error_passive: bool = False) -> None:
        instance("frame", frame, Frame)
        self.levels = bytearray(_MOST_BITS)
        self.fields = bytearray(_MOST_BITS)
        self.stuffed = bytearray(_MOST_BITS)
        self._length = 0
        self.stuff_bits = 0
        self.crc = 0
        self._run = 0
        self._last = 1
        self._covering = True
        self._choose_crc(frame, fd_mode == NON_ISO)
        self._header(frame, frame.error_state_indicator or error_passive)
        self._data(frame)
        if frame.fd:
            self._fd_crc(fd_mode == NON_ISO)
        else:
            self._classic_crc()
        # a stuff bit right after BRS counts to ESI: it runs at the data rate already
        after_brs = self.fields.find(_ESI) if frame.bit_rate_switch else self._length
        self.data_bits = self._length - after_brs
        self._tail()
        for bits in (self.levels, self.fields, self.stuffed):
            del bits[self._length :]

    def __repr__(self) -> str:
        return f"<{len(self.levels)} bits on the wire, {sum(self.stuffed)} of them stuff bits, CRC {self.crc:#x}>"

    def ack_slot(self) -> int:
        """Index of the ACK slot."""
        return self.fields.index(_INDEX["ACK"])

    def find(self, field: str) -> int:
        """Index of the first bit of a field that is no stuff bit, or -1 if this frame has none.

        Raises BadValue for an unknown field.
        """
        wanted = _INDEX.get(field) if isinstance(field, str) else None
        if wanted is None:
            raise BadValue(f"field {shown(field)}: one of {', '.join(FIELDS)}")
        found = [k for k, name in enumerate(self.fields) if name == wanted and not self.stuffed[k]]
        return found[0] if found else -1

    def first_fixed_stuff_bit(self) -> int:
        """Index of the bit where an FD frame's fixed stuffing begins, or -1 in a classic frame."""
        starts = (self.fields.find(_INDEX["STUFF COUNT"]), self.fields.find(_INDEX["CRC"]))
        fd = any(self.fields[k] == _INDEX["ESI"] for k in range(len(self.fields)))
        return min(start for start in starts if start >= 0) if fd else -1

    def _choose_crc(self, frame: Frame, non_iso: bool) -> None:
        """Choose the CRC: CRC-15 covers the bits without stuff bits, CRC-17 and CRC-21 cover the stuff bits too."""
        self._wide = frame.fd
        if not frame.fd:
            self._width, self._poly, self.crc = 15, CRC15_POLY, 0
        elif len(frame.data) <= 16:
            self._width, self._poly, self.crc = 17, CRC17_POLY, 0 if non_iso else CRC17_ISO_START
        else:
            self._width, self._poly, self.crc = 21, CRC21_POLY, 0 if non_iso else CRC21_ISO_START

    def _header(self, frame: Frame, error_passive: bool) -> None:
        remote, id = int(frame.remote), frame.id
        self._put(_SOF, 0, 1)
        if frame.extended:
            self._put(_ID, id >> 18, 11)
            self._put(_RTR, 1, 1)
            self._put(_IDE, 1, 1)
            self._put(_EXT, id & 0x3FFFF, 18)
            self._put(_RTR2, remote, 1)
        else:
            self._put(_ID, id, 11)
            self._put(_RTR, remote, 1)
            self._put(_IDE, 0, 1)
        self._put(_FDF, int(frame.fd), 1)
        if frame.fd:
            self._put(_RES, 0, 1)
            self._put(_BRS, int(frame.bit_rate_switch), 1)
            self._put(_ESI, int(error_passive), 1)
        elif frame.extended:
            self._put(_R0, 0, 1)
        self._put(_DLC, frame.dlc, 4)

    def _data(self, frame: Frame) -> None:
        data = frame.data
        for k in range(len(data)):
            self._put(_DATA, data[k], 8)

    def _classic_crc(self) -> None:
        self._covering = False
        self._put(_CRC, self.crc, 15)
        if self._run == 5:
            self._stuff(_CRC)

    def _fd_crc(self, non_iso: bool) -> None:
        if not non_iso:
            self._put_fixed(_STUFF_COUNT, STUFF_COUNT_CODE[self.stuff_bits & 7], 4, 0)
        self._covering = False
        self._put_fixed(_CRC, self.crc, self._width, 0 if non_iso else 4)

    def _put_fixed(self, field: int, value: int, width: int, before: int) -> None:
        """Append bits with a fixed stuff bit before every four of them; `before` bits of the first group are already
        there.
        """
        for k in range(width):
            if (before + k) % 4 == 0:
                self._append(field, 1 - self._last, 1)
            level = value >> (width - 1 - k) & 1
            if self._covering:
                self._cover(level)
            self._append(field, level, 0)

    def _tail(self) -> None:
        self._append(_CRC_DEL, 1, 0)
        self._append(_ACK, 1, 0)
        self._append(_ACK_DEL, 1, 0)
        for _ in range(_EOF_BITS):
            self._append(_EOF, 1, 0)

    def _put(self, field: int, value: int, width: int) -> None:
        for k in range(width - 1, -1, -1):
            level = value >> k & 1
            if self._run == 5:
                self._stuff(field)
            if self._covering:
                self._cover(level)
            self._run = self._run + 1 if level == self._last and self._run else 1
            self._append(field, level, 0)

    def _stuff(self, field: int) -> None:
        level = 1 - self._last
        self._append(field, level, 1)
        self._run = 1
        self.stuff_bits += 1
        if self._wide and self._covering:
            self._cover(level)

    def _cover(self, level: int) -> None:
        self.crc = _shifted(self.crc, level, self._width, self._poly)

    def _append(self, field: int, level: int, stuffed: int) -> None:
        self._last = level
        self.levels[self._length] = level
        self.fields[self._length] = field
        self.stuffed[self._length] = stuffed
        self._length += 1


class KeptLayout:
    """The layout of a node's frame, kept for repetitions after a lost arbitration or an error.

    `levels` are those that its sender drives, `heard` those of the wire if the frame is acknowledged. `fast_bit` is its
    BRS bit (-1: the rate stays), `tail_bit` its CRC delimiter; `classic` says that it is no FD frame. `box` has its
    record, `length` is the number of its data bytes, `stuff_bits` counts its dynamic stuff bits.
    """

    def __init__(self) -> None:
        self.levels = self.heard = b""
        self.fast_bit = self.tail_bit = -1
        self.stuff_bits = self.length = 0
        self.classic = True
        self.box = Mailbox()
        self._fd_mode = -1

    def take(self, box: Mailbox, fd_mode: int) -> None:
        """Lay out this frame, unless the stored layout is already that of the same frame."""
        if fd_mode != self._fd_mode or not self._holds(box):
            frame = codec.frame_at(box.words, 0)
            layout = BitLayout(frame, fd_mode=fd_mode)
            self.levels = bytes(layout.levels)
            self.tail_bit = len(layout.levels) - _TAIL_BITS
            layout.levels[self.tail_bit + 1] = 0
            self.heard = bytes(layout.levels)
            self.stuff_bits = layout.stuff_bits
            self.length = len(frame.data)
            self.fast_bit = self.tail_bit - layout.data_bits - 1 if layout.data_bits else -1
            self.classic = not frame.fd
            self._fd_mode = fd_mode
            _mem.copy_record(self.box.words, 0, box.words, 0)

    def _holds(self, box: Mailbox) -> bool:
        """Whether the stored record equals this mailbox's, the time stamp ignored."""
        ours, theirs = self.box.words, box.words
        for k in range(1, _RECORD_WORDS):
            if ours[k] != theirs[k]:
                return False
        return True


def crc_of(bits: list[int], poly: int, width: int, start: int) -> int:
    """CRC of a bit sequence, most significant bit first; `poly` without its top bit."""
    register = start
    for bit in bits:
        register = _shifted(register, bit, width, poly)
    return register


def _shifted(register: int, bit: int, width: int, poly: int) -> int:
    fed_back = bit ^ register >> (width - 1)
    register = register << 1 & ((1 << width) - 1)
    return register ^ poly if fed_back else register
