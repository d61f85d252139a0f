# cython: nonecheck=False
"""The state of a frame reader: stored as a record, compared with another reader's, and copied to another reader.

Of several readers in the same state only one needs to read the next bits; coasting.py compares them.
"""

from __future__ import annotations

from canwire import _mem
from canwire.bus.can.frame_reader import DATA, FrameReader

_DATA = DATA
_WORDS = 8  # of a record's data
_EXTENDED, _REMOTE, _FD, _SWITCH, _ESI = 1 << 23, 1 << 22, 1 << 10, 1 << 11, 1 << 12  # of its info
_DLC_SHIFT = 16


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
    for k in range(_WORDS):
        words[2 + k] = reader.payload[k] if k < used else 0


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
