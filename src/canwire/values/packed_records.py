"""Records packed for a network: 80 bytes each in memory, and as many as they need on the way.

    0   2    count
    2   1    unit of the differences between stamps, ns
    3   8    time_ns of the first record
    11       the records, each:
             difference to the stamp before, in units, 7 bits a byte, lowest first, the top bit set in all but the last
             1 byte: data length code | INFO | LONG | EXPLICIT | BACK
             4 bytes of info without its data length code (INFO: it is not that of the record before)
             2 bytes of the identifier, 4 (LONG)
             1 byte: how many data bytes follow (EXPLICIT; otherwise as many as the code says), the rest being zeros
             data

Numbers are little-endian. Any 80 bytes come out as they went in; a classic frame takes 13 to 24 of them, most take 14.
"""

from __future__ import annotations

from canwire import _mem
from canwire.errors import BadMessage
from canwire.values.dlc import FD_LENGTHS
from canwire.values.record import RECORD_SIZE

_SIZE = RECORD_SIZE
_WORDS = 10
_HEAD = 11
_SMALLEST, _LARGEST = 4, 84  # bytes of a packed record
_COARSE_NS = 100  # stamps of most bit rates are multiples of it
_INFO, _LONG, _EXPLICIT, _BACK = 1 << 4, 1 << 5, 1 << 6, 1 << 7
_CODE, _DLC_SHIFT, _FD = 0xF, 16, 1 << 10
_MOST_CLASSIC, _MOST = 8, 64
_LENGTHS = bytes(FD_LENGTHS)
_M32 = (1 << 32) - 1
_M64 = (1 << 64) - 1
_TOP = 1 << 63
_LONGEST_NUMBER = 10  # bytes of a number of 64 bits
_NOWHERE = (1 << 31) - 1  # behind the end of anything packed


def pack(records: bytearray) -> bytes:
    """Pack all records, at most 65,535."""
    words = _mem.words_of(records)
    count = len(records) // _SIZE
    room = bytearray(_HEAD + count * _LARGEST)
    if not count:
        return bytes(room)
    unit = _unit(words, count)
    at = _put(room, 0, count, 2)
    at = _put(room, at, unit, 1)
    at = _put(room, at, words[0], 8)
    before, before_info = words[0], 0
    for k in range(count):
        first = k * _WORDS
        info = words[first + 1] >> 32
        at = _put_record(room, at, words, first, _apart(words[first], before) // unit, before, before_info)
        before, before_info = words[first], info & ~(_CODE << _DLC_SHIFT)
    return bytes(room[:at])


def unpack(packed: bytes) -> bytearray:
    """The records; raises BadMessage for bytes that `pack` does not produce."""
    size = len(packed)
    count = _get(packed, 0, 2) if size >= _HEAD else 0
    unit = _get(packed, 2, 1) if size >= _HEAD else 0
    if size < _HEAD or count * _SMALLEST > size - _HEAD or (count > 0 and unit == 0):
        raise BadMessage(f"{size} bytes of packed records: {count} of them, stamps in {unit} ns")
    padded = packed + bytes(_LARGEST)  # so that no record reads beyond
    records = bytearray(count * _SIZE)
    if count:
        words = _mem.words_of(records)
        at, before, info = _HEAD, _get(packed, 3, 8), 0
        for k in range(count):
            at = _get_record(padded, at, words, k * _WORDS, before, unit, info)
            if at > size:
                raise BadMessage(f"{size} bytes of packed records: record {k} of {count} is not whole")
            before = words[k * _WORDS]
            info = (words[k * _WORDS + 1] >> 32) & ~(_CODE << _DLC_SHIFT)
        size -= at - _HEAD
    if size != _HEAD:
        raise BadMessage(f"{size - _HEAD} bytes too many behind {count} packed records")
    return records


def _unit(words: _mem.Words, count: int) -> int:
    """The largest unit of which all differences are multiples."""
    for k in range(1, count):
        if _apart(words[k * _WORDS], words[(k - 1) * _WORDS]) % _COARSE_NS:
            return 1
    return _COARSE_NS


def _apart(stamp: int, before: int) -> int:
    """The distance between two stamps of a counter that wraps, without its sign."""
    apart = (stamp - before) & _M64
    return (before - stamp) & _M64 if apart & _TOP else apart


def _put(room: bytearray, at: int, value: int, size: int) -> int:
    for _ in range(size):
        room[at] = value & 0xFF
        value >>= 8
        at += 1
    return at


def _get(packed: bytes, at: int, size: int) -> int:
    value = 0
    while size > 0:
        size -= 1
        value = value << 8 | packed[at + size]
    return value


def _put_record(
    room: bytearray, at: int, words: _mem.Words, first: int, apart: int, before: int, before_info: int
) -> int:
    identifier, info = words[first + 1] & _M32, words[first + 1] >> 32
    code = (info >> _DLC_SHIFT) & _CODE
    rest = info & ~(_CODE << _DLC_SHIFT)
    length, used = _implied(info, code), _used(words, first + 2)
    mark = code
    if rest != before_info:
        mark |= _INFO
    if identifier >> 16:
        mark |= _LONG
    if used > length or used + 1 < length:
        mark |= _EXPLICIT
        length = used
    if ((words[first] - before) & _M64) & _TOP:
        mark |= _BACK
    while apart > 0x7F:
        room[at] = apart & 0x7F | 0x80
        apart >>= 7
        at += 1
    room[at] = apart & 0x7F
    room[at + 1] = mark
    at += 2
    if mark & _INFO:
        at = _put(room, at, rest, 4)
    at = _put(room, at, identifier, 4 if mark & _LONG else 2)
    if mark & _EXPLICIT:
        at = _put(room, at, length, 1)
    word = first + 2
    while length > 8:
        at = _put(room, at, words[word], 8)
        word += 1
        length -= 8
    return _put(room, at, words[word], length) if length else at


def _get_record(
    packed: bytes, at: int, words: _mem.Words, first: int, before: int, unit: int, info: int
) -> int:
    apart, shift = 0, 0
    part = packed[at]
    while part & 0x80 and shift < 7 * (_LONGEST_NUMBER - 1):
        apart |= (part & 0x7F) << shift
        shift += 7
        at += 1
        part = packed[at]
    apart = ((apart | (part & 0x7F) << shift) * unit) & _M64
    mark = packed[at + 1]
    at += 2
    words[first] = (before - apart if mark & _BACK else before + apart) & _M64
    if mark & _INFO:
        info = _get(packed, at, 4) & ~(_CODE << _DLC_SHIFT)
        at += 4
    size = 4 if mark & _LONG else 2
    code = mark & _CODE
    info |= code << _DLC_SHIFT
    words[first + 1] = info << 32 | _get(packed, at, size)
    at += size
    length = _implied(info, code)
    if mark & _EXPLICIT:
        length = packed[at]
        at += 1
        if length > _MOST:
            return _NOWHERE
    word = first + 2
    while length > 8:
        words[word] = _get(packed, at, 8)
        word += 1
        at += 8
        length -= 8
    if length:
        words[word] = _get(packed, at, length)
    return at + length


def _implied(info: int, code: int) -> int:
    """The number of data bytes that the length code means."""
    return _LENGTHS[code] if info & _FD else min(code, _MOST_CLASSIC)


def _used(words: _mem.Words, first: int) -> int:
    """Data bytes up to the last one that is not zero."""
    word = 8
    while word > 0 and words[first + word - 1] == 0:
        word -= 1
    if word == 0:
        return 0
    value, used = words[first + word - 1], (word - 1) * 8
    while value:
        value >>= 8
        used += 1
    return used
