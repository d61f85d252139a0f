"""Frames as bits: stuffing, CRC 15/17/21, lengths, and which field each bit belongs to.

`measure` computes the length of a frame byte by byte from tables; `encode` lays out every bit.
Source: ISO 11898-1:2015 chapters 8.4 and 10.4; reference/can-protocol.md sections 1 to 4.
"""

from __future__ import annotations

from array import array

from canwire import _mem
from canwire.bus.can.node import Mailbox
from canwire.values.dlc import FD_LENGTHS

_EXTENDED = 1 << 23
_REMOTE = 1 << 22
_FD = 1 << 10
_BIT_RATE_SWITCH = 1 << 11
_ERROR_STATE = 1 << 12
_ESI_WORD = 1 << 44  # ESI in a record's id/info word
_NON_ISO = 2
NON_ISO = _NON_ISO  # a value of `Node.fd`: CAN FD as Bosch first specified it, without the stuff count

CRC15_POLY = 0x4599
CRC17_POLY = 0x1685B
CRC21_POLY = 0x102899
CRC17_ISO_START = 1 << 16
CRC21_ISO_START = 1 << 20
STUFF_COUNT_CODE = (0b0000, 0b0011, 0b0110, 0b0101, 0b1100, 0b1111, 0b1010, 0b1001)

_TAIL_BITS = 10  # CRC delimiter, ACK slot, ACK delimiter, EOF
_IDLE = 8 << 8  # the state in which a frame finds the bus: last bit recessive, run of none
START_STATE = _IDLE
_STATE = 0xF00
# alternating bits that make a header whole bytes; the last is recessive, so they change nothing
_BEFORE_39, _BEFORE_36, _BEFORE_19, _BEFORE_17 = 0b1 << 7, 0b0101 << 4, 0b10101 << 3, 0b1010101 << 1


def _crc15_table() -> array[int]:
    """The contribution of a byte to the CRC, by the number of bytes after it (0..12), at index bytes << 8 | byte."""
    table = array("H")
    for follow in range(13):
        for byte in range(256):
            register = byte << 7 if follow == 0 else table[(follow - 1) << 8 | byte]
            for _ in range(8):
                register = (register << 1) ^ (CRC15_POLY if register & 0x4000 else 0)
            table.append(register & 0x7FFF)
    return table


def _stuff_tables(count: int) -> tuple[array[int], array[int]]:
    """For groups of `count` bits, at index state | bits: the next state, and the number of stuff bits inserted.

    A state is (last bit << 3 | run length 0..5) << 8. A stuff bit is inserted when the bit after a run of five is
    about to come, so a run that ends a CAN FD data field stays without one.
    """
    states, inserted = array("H", bytes(2 << 12)), array("H", bytes(2 << 12))
    for first in range(16):
        for bits in range(1 << count):
            last, run, number = first >> 3, first & 7, 0
            for k in range(count - 1, -1, -1):
                bit = bits >> k & 1
                if run == 5:
                    last, run, number = 1 - last, 1, number + 1
                last, run = bit, run + 1 if bit == last and run else 1
            states[first << 8 | bits] = (last << 3 | run) << 8
            inserted[first << 8 | bits] = number
    return states, inserted


_CRC15_BLOCK = _crc15_table()
_NEXT_BLOCK, _INSERTED_BLOCK = _stuff_tables(8)
_NEXT5_BLOCK, _INSERTED5_BLOCK = _stuff_tables(5)
_CRC15 = _mem.shorts_of(_CRC15_BLOCK)
_NEXT, _INSERTED = _mem.shorts_of(_NEXT_BLOCK), _mem.shorts_of(_INSERTED_BLOCK)
_NEXT5, _INSERTED5 = _mem.shorts_of(_NEXT5_BLOCK), _mem.shorts_of(_INSERTED5_BLOCK)
_LENGTH_BLOCK = array("H", FD_LENGTHS)
_LENGTHS = _mem.shorts_of(_LENGTH_BLOCK)


def measure(box: Mailbox, fd_mode: int) -> None:
    """Fill in `key`, `bits` and `data_bits` from the record in `box.words`."""
    head = box.words[1]
    info = head >> 32
    identifier = head & 0x1FFFFFFF
    remote = 1 if info & _REMOTE else 0
    if info & _EXTENDED:
        box.key = identifier >> 18 << 21 | 0x180000 | (identifier & 0x3FFFF) << 1 | remote
    else:
        box.key = identifier << 21 | remote << 20
    if info & _FD:
        _measure_fd(box, head, fd_mode)
    else:
        box.data_bits = 0
        box.bits = _measure_classic(box.words, head)


def show_error_state(box: Mailbox, passive: bool, fd_mode: int) -> None:
    """Set the ESI bit of an FD frame if its sender is error passive; stuff bits may move, so the frame is measured
    again.
    """
    shown = box.words[1] & _ESI_WORD != 0
    if (passive and not shown) or (box.esi_added and not passive):
        box.words[1] = box.words[1] ^ _ESI_WORD
        box.esi_added = not box.esi_added
        measure(box, fd_mode)


def _measure_classic(words: _mem.Words, head: int) -> int:
    """The number of bits from SOF to the end of EOF."""
    info = head >> 32
    identifier = head & 0x1FFFFFFF
    dlc = info >> 16 & 15
    remote = 1 if info & _REMOTE else 0
    after = 0 if remote else (dlc if dlc < 8 else 8) << 8  # bytes that follow, as an index of the table
    if info & _EXTENDED:  # SOF, base, SRR, IDE, extension, RTR, r1, r0, DLC: 39 bits
        header = (identifier >> 18 << 20 | 3 << 18 | identifier & 0x3FFFF) << 7 | remote << 6 | dlc
        at = _IDLE | _BEFORE_39 | header >> 32
        bits = 64 + _INSERTED[at]
        at = _NEXT[at] | header >> 24 & 255
        bits += _INSERTED[at]
        crc = _CRC15[after + 0x400 | header >> 32] ^ _CRC15[after + 0x300 | header >> 24 & 255]
        at = _NEXT[at] | header >> 16 & 255
    else:  # SOF, base, RTR, IDE, r0, DLC: 19 bits
        header = identifier << 7 | remote << 6 | dlc
        bits = 44
        crc = 0
        at = _IDLE | _BEFORE_19 | header >> 16
    bits += _INSERTED[at]
    crc ^= _CRC15[after + 0x200 | header >> 16 & 255] ^ _CRC15[after + 0x100 | header >> 8 & 255]
    at = _NEXT[at] | header >> 8 & 255
    bits += _INSERTED[at]
    at = _NEXT[at] | header & 255
    bits += _INSERTED[at] + (after >> 5)
    crc ^= _CRC15[after | header & 255]
    state = _NEXT[at]
    data = words[2]
    while after:
        after -= 0x100
        byte = data & 255
        data >>= 8
        at = state | byte
        state = _NEXT[at]
        bits += _INSERTED[at]
        crc ^= _CRC15[after | byte]
    at = state | crc >> 7
    bits += _INSERTED[at]
    at = _NEXT[at] | crc << 1 & 255  # one bit more, before which a run of five is stuffed
    return bits + _INSERTED[at]


def _stuffed(state: int, data: int, length: int) -> int:
    """The state after this many bytes of `data`, lowest first, and in its low byte the number of their stuff bits."""
    count = 0
    while length > 0:
        length -= 1
        at = state | data & 255
        state = _NEXT[at]
        count += _INSERTED[at]
        data >>= 8
    return state | count


def _measure_fd(box: Mailbox, head: int, fd_mode: int) -> None:
    """The state in which a byte leaves nearly always follows from that byte alone, so the look-ups of a word begin
    with this `guess`, and need not wait for those of the word before.
    """
    words = box.words
    info = head >> 32
    identifier = head & 0x1FFFFFFF
    dlc = info >> 16 & 15
    left = _LENGTHS[dlc]
    switch = 1 if info & _BIT_RATE_SWITCH else 0
    if info & _EXTENDED:  # SOF, base, SRR, IDE, extension, RRS, FDF, res, BRS: 36 bits
        header = (identifier >> 18 << 20 | 3 << 18 | identifier & 0x3FFFF) << 4 | 4 | switch
        at = _IDLE | _BEFORE_36 | header >> 32
        nominal = 36 + _INSERTED[at]
        at = _NEXT[at] | header >> 24 & 255
        nominal += _INSERTED[at]
        at = _NEXT[at] | header >> 16 & 255
    else:  # SOF, base, RRS, IDE, FDF, res, BRS: 17 bits
        header = identifier << 5 | 4 | switch
        nominal = 17
        at = _IDLE | _BEFORE_17 | header >> 16
    nominal += _INSERTED[at]
    at = _NEXT[at] | header >> 8 & 255
    nominal += _INSERTED[at]
    at = _NEXT[at] | header & 255
    nominal += _INSERTED[at]
    at = _NEXT[at] | (16 if info & _ERROR_STATE else 0) | dlc
    bits = 5 + 8 * left + (27 if left <= 16 else 32) - (5 if fd_mode == _NON_ISO else 0)
    bits += _INSERTED5[at]
    state = _NEXT5[at]
    guess = state
    at = 2
    while left > 0:
        data = words[at]
        at += 1
        step = _stuffed(guess, data, left if left < 8 else 8)
        if guess != state:
            step = _stuffed(state, data, left if left < 8 else 8)
        bits += step & 255
        state = step & _STATE
        guess = _NEXT[_IDLE | data >> 56]
        left -= 8
    box.bits = nominal + bits + _TAIL_BITS
    box.data_bits = bits if switch else 0
