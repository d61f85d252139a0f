"""A frame laid out bit by bit, as its sender drives it: levels, fields, stuff bits, CRC.

The slow, obvious twin of can_bits.measure: what the bit level transmits and `canwire bits` draws.
Source: ISO 11898-1:2015 chapter 10.4; reference/can-protocol.md sections 1 to 4.
"""

from __future__ import annotations

from canwire.bus.can.bits import (
    CRC15_POLY,
    CRC17_ISO_START,
    CRC17_POLY,
    CRC21_ISO_START,
    CRC21_POLY,
    NON_ISO,
    STUFF_COUNT_CODE,
)
from canwire.errors import BadValue
from canwire.values.arguments import SignatureOf
from canwire.values.checks import instance, shown
from canwire.values.dlc import dlc_to_length
from canwire.values.frame import Frame

FIELDS = (
    "SOF", "ID", "RTR", "IDE", "EXT", "RTR2", "FDF", "r0", "res", "BRS", "ESI", "DLC", "DATA",
    "STUFF COUNT", "CRC", "CRC DEL", "ACK", "ACK DEL", "EOF",
)  # fmt: skip
_INDEX = {name: index for index, name in enumerate(FIELDS)}
DOMINANT, RECESSIVE = 0, 1


def _prototype(frame: Frame, *, fd_mode: int = 0, error_passive: bool = False) -> None:
    """How BitLayout is called, for help()."""


class BitLayout:
    """Every bit of one frame from SOF to the last EOF bit; the ACK slot is recessive, as a sender drives it.

    `levels`, `fields` (index into FIELDS) and `stuffed` (1 for dynamic and fixed stuff bits) hold one
    byte a bit. `stuff_bits` counts dynamic stuff bits, `data_bits` the bits at the data rate
    from the one after BRS to the last CRC bit, `crc` is the value sent.
    """

    __signature__ = SignatureOf(_prototype)

    def __init__(self, frame: Frame, *, fd_mode: int = 0, error_passive: bool = False) -> None:
        instance("frame", frame, Frame)
        self.levels = bytearray()
        self.fields = bytearray()
        self.stuffed = bytearray()
        self.stuff_bits = 0
        self.crc = 0
        self._run = 0
        self._last = 1
        self._plain: list[int] = []  # SOF to data without stuff bits: what CRC-15 covers
        self._wired: list[int] = []  # and with them: what CRC-17 and CRC-21 cover
        self._header(frame, frame.error_state_indicator or error_passive)
        self._data(frame)
        if frame.fd:
            self._fd_crc(len(frame.data), fd_mode == NON_ISO)
        else:
            self._classic_crc()
        # a stuff bit right after BRS counts to ESI: it runs at the data rate already
        after_brs = self.fields.find(_INDEX["ESI"]) if frame.bit_rate_switch else len(self.levels)
        self.data_bits = len(self.levels) - after_brs
        self._tail()

    def __repr__(self) -> str:
        return f"<{len(self.levels)} bits on the wire, {sum(self.stuffed)} of them stuff bits, CRC {self.crc:#x}>"

    def ack_slot(self) -> int:
        """Index of the ACK slot."""
        return self.fields.index(_INDEX["ACK"])

    def find(self, field: str) -> int:
        """Index of the first bit of a field that is no stuff bit, or -1 if this frame has none.

        Raises BadValue for what no frame has.
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

    def _header(self, frame: Frame, error_passive: bool) -> None:
        remote = int(frame.remote)
        self._put("SOF", 0, 1)
        if frame.extended:
            self._put("ID", frame.id >> 18, 11)
            self._put("RTR", 1, 1)
            self._put("IDE", 1, 1)
            self._put("EXT", frame.id & 0x3FFFF, 18)
            self._put("RTR2", remote, 1)
        else:
            self._put("ID", frame.id, 11)
            self._put("RTR", remote, 1)
            self._put("IDE", 0, 1)
        self._put("FDF", int(frame.fd), 1)
        if frame.fd:
            self._put("res", 0, 1)
            self._put("BRS", int(frame.bit_rate_switch), 1)
            self._put("ESI", int(error_passive), 1)
        elif frame.extended:
            self._put("r0", 0, 1)
        self._put("DLC", frame.dlc, 4)

    def _data(self, frame: Frame) -> None:
        length = 0 if frame.remote else dlc_to_length(frame.dlc, fd=frame.fd)
        for byte in frame.data[:length]:
            self._put("DATA", byte, 8)

    def _classic_crc(self) -> None:
        self.crc = crc_of(self._plain, CRC15_POLY, 15, 0)
        self._put("CRC", self.crc, 15)
        if self._run == 5:
            self._stuff("CRC")

    def _fd_crc(self, length: int, non_iso: bool) -> None:
        width, poly, start = (
            (17, CRC17_POLY, CRC17_ISO_START) if length <= 16 else (21, CRC21_POLY, CRC21_ISO_START)
        )
        code = [] if non_iso else _bits_of(STUFF_COUNT_CODE[self.stuff_bits & 7], 4)
        self.crc = crc_of(self._wired + code, poly, width, 0 if non_iso else start)
        for k, level in enumerate(code + _bits_of(self.crc, width)):
            field = "STUFF COUNT" if k < len(code) else "CRC"
            if k % 4 == 0:
                self._append(field, 1 - self._last, 1)
            self._append(field, level, 0)

    def _tail(self) -> None:
        for field, count in (("CRC DEL", 1), ("ACK", 1), ("ACK DEL", 1), ("EOF", 7)):
            for _ in range(count):
                self._append(field, RECESSIVE, 0)

    def _put(self, field: str, value: int, width: int) -> None:
        for k in range(width - 1, -1, -1):
            level = value >> k & 1
            if self._run == 5:
                self._stuff(field)
            self._plain.append(level)
            self._wired.append(level)
            self._run = self._run + 1 if level == self._last and self._run else 1
            self._append(field, level, 0)

    def _stuff(self, field: str) -> None:
        level = 1 - self._last
        self._append(field, level, 1)
        self._run = 1
        self.stuff_bits += 1
        self._wired.append(level)

    def _append(self, field: str, level: int, stuffed: int) -> None:
        self._last = level
        self.levels.append(level)
        self.fields.append(_INDEX[field])
        self.stuffed.append(stuffed)


def crc_of(bits: list[int], poly: int, width: int, start: int) -> int:
    """CRC of a bit sequence, most significant bit first; `poly` without its top bit."""
    register = start
    for bit in bits:
        fed_back = bit ^ register >> (width - 1)
        register = register << 1 & (1 << width) - 1 ^ (poly if fed_back else 0)
    return register


def _bits_of(value: int, width: int) -> list[int]:
    return [value >> k & 1 for k in range(width - 1, -1, -1)]
