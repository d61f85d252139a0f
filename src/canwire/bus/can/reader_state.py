# cython: nonecheck=False
"""The state of a frame reader: as a record, beside another reader's, copied to another one, and what it means.

Of several readers in the same state only one needs to read the next bits; coasting.py compares them.
"""

from __future__ import annotations

from canwire import _mem
from canwire.bus.can.bit_layout import KeptLayout
from canwire.bus.can.frame_reader import BASE, CRC_DELIMITER, DATA, EOF, EXT, FDF, FrameReader

_BASE, _EXT, _FDF, _DATA, _CRC_DELIMITER, _EOF = BASE, EXT, FDF, DATA, CRC_DELIMITER, EOF
_ACK_SLOT, _EOF_FROM, _EOF_BITS = 1, 3, 7  # counted from the CRC delimiter; how many
_WORDS = 8  # of a record's data
_EXTENDED, _REMOTE, _FD, _SWITCH, _ESI = 1 << 23, 1 << 22, 1 << 10, 1 << 11, 1 << 12  # of its info
_DLC_SHIFT, _IDENTIFIER = 16, 0x1FFFFFFF

# by field: segment codes of the SJA1000's error code capture register (data sheet table 20); those of FD fields, which
# no SJA1000 reads to their end, are its reserved bits'
_PARTS = bytes((
    0x03, 0x02, 0x04, 0x05, 0x07, 0x0C, 0x09, 0x09, 0x0D, 0x0D, 0x0D, 0x0B, 0x0A,
    0x08, 0x08, 0x18, 0x19, 0x1B, 0x1A,
))  # fmt: skip


def store(reader: FrameReader, words: _mem.Words) -> None:
    """Write the frame read to a record, once its CRC was right."""
    head = reader.dlc << _DLC_SHIFT
    if reader.extended:
        head |= _EXTENDED
    if reader.remote:
        head |= _REMOTE
    if reader.fd:
        head |= _FD
        if reader.switch:
            head |= _SWITCH
        if reader.esi:
            head |= _ESI
    words[0] = 0
    words[1] = head << 32 | reader.identifier
    used = (reader.length + 7) // 8
    for k in range(used):
        words[2 + k] = reader.payload[k]
    for k in range(used, _WORDS):
        words[2 + k] = 0


def finish(reader: FrameReader, layout: KeptLayout) -> None:
    """Continue at the CRC delimiter: the reader has read all bits of this frame before it."""
    words, one = layout.box.words, 1
    head = words[1] >> 32
    reader.identifier = words[1] & _IDENTIFIER
    reader.extended = head & _EXTENDED != 0
    reader.remote = head & _REMOTE != 0
    reader.fd = head & _FD != 0
    reader.switch = head & _SWITCH != 0
    reader.esi = head & _ESI != 0
    reader.dlc = head >> _DLC_SHIFT & 15
    reader.length = layout.length
    reader.stuff_count = layout.stuff_bits
    whole, rest = layout.length // 8, layout.length % 8
    for k in range(whole):
        reader.payload[k] = words[2 + k]
    if rest:
        reader.payload[whole] = words[2 + whole] & ((one << 8 * rest) - 1)
    reader.last = layout.levels[layout.tail_bit - 1]
    reader.stuffing = False
    reader.same = reader.crc_position = 0
    reader.crc15 = reader.crc17 = reader.crc21 = 0
    reader.crc_ok = True
    reader.go_on(_CRC_DELIMITER, 1)


def pass_tail(reader: FrameReader, bits: int) -> None:
    """Continue after so many bits, from its CRC delimiter on, of a frame that is acknowledged."""
    if bits < _EOF_FROM:
        reader.go_on(_CRC_DELIMITER + bits, 1)
        reader.last = 1 if bits == _ACK_SLOT else 0
    else:
        reader.go_on(_EOF, _EOF_BITS - (bits - _EOF_FROM))
        reader.value = (1 << (bits - _EOF_FROM)) - 1
        reader.last = 1


def alike(one: FrameReader, other: FrameReader, classic: bool) -> bool:
    """Whether both are at the same place of the same frame, and will read the next bits alike.

    `classic` means that the bits are those of a classic frame, which readers with different FD settings read alike.
    """
    same = (
        one.field == other.field
        and one.left == other.left
        and one.value == other.value
        and one.same == other.same
        and one.last == other.last
        and one.stuffing == other.stuffing
        and one.stuff_count == other.stuff_count
        and one.crc15 == other.crc15
        and one.crc17 == other.crc17
        and one.crc21 == other.crc21
        and one.crc_position == other.crc_position
    )
    same = same and (
        classic or (one.fd_mode == other.fd_mode and one.protocol_exception == other.protocol_exception)
    )
    return same and _have_read_the_same(one, other)


def _have_read_the_same(one: FrameReader, other: FrameReader) -> bool:
    same = (
        one.identifier == other.identifier
        and one.dlc == other.dlc
        and one.extended == other.extended
        and one.remote == other.remote
        and one.fd == other.fd
        and one.switch == other.switch
        and one.esi == other.esi
        and one.crc_ok == other.crc_ok
        and one.length == other.length
    )
    if same and one.field >= _DATA:
        for k in range((_whole_bytes(one) + 7) // 8):
            same = same and one.payload[k] == other.payload[k]
    return same


def _whole_bytes(reader: FrameReader) -> int:
    """How many whole bytes of the data the reader has read."""
    return reader.length - (reader.left + 7) // 8 if reader.field == _DATA else reader.length


def copy(target: FrameReader, source: FrameReader) -> None:
    """Copy the position and the values of the source."""
    target.field, target.left, target.value = source.field, source.left, source.value
    target.same, target.last, target.stuffing = source.same, source.last, source.stuffing
    target.stuff_count = source.stuff_count
    target.crc_position, target.crc_width = source.crc_position, source.crc_width
    target.crc15, target.crc17, target.crc21 = source.crc15, source.crc17, source.crc21
    target.crc_ok = source.crc_ok
    target.identifier, target.extended, target.remote = source.identifier, source.extended, source.remote
    target.fd, target.switch, target.esi = source.fd, source.switch, source.esi
    target.dlc, target.length = source.dlc, source.length
    if source.field >= _DATA:
        for k in range((_whole_bytes(source) + 7) // 8):
            target.payload[k] = source.payload[k]


def double(target: FrameReader, source: FrameReader) -> None:
    """Copy the source with its format settings, so that both read the next bits alike."""
    target.fd_mode, target.protocol_exception = source.fd_mode, source.protocol_exception
    copy(target, source)


def part(reader: FrameReader) -> int:
    """The part of a classic frame that the next bit belongs to, as a segment code of SJA1000's ECC register."""
    field, left = reader.field, reader.left
    if field == _BASE:
        return 0x02 if left > 3 else 0x06
    if field == _EXT:
        return 0x07 if left > 13 else 0x0F if left > 5 else 0x0E
    if field == _FDF:
        return 0x0D if reader.extended else 0x09
    return _PARTS[field]
