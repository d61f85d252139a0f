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
_START_STATE = 8 << 8  # last bit recessive, run of none
START_STATE = _START_STATE


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


def _stuff_tables() -> list[array[int]]:
    """For groups of 0..8 bits, by state << 8 | bits: next state << 8 | stuff bits inserted.

    A state is last bit << 3 | run length 0..5; its position suits the next look-up. A stuff bit
    is inserted when the bit after a run of five is about to come, so a run that ends a CAN FD data field
    stays without one.
    """
    one = [_stuffed(state, bits & 1) for state in range(16) for bits in range(256)]
    tables = [array("H"), array("H", one)]
    for count in range(2, 9):
        shorter = tables[count - 1]
        table = array("H", bytes(2 * 16 * 256))
        for state in range(16):
            for bits in range(1 << count):
                table[state << 8 | bits] = _then(shorter[state << 8 | bits >> 1], one, bits & 1)
        tables.append(table)
    return tables


def _stuffed(state: int, bit: int) -> int:
    last, run, inserted = state >> 3, state & 7, 0
    if run == 5:
        last, run, inserted = 1 - last, 1, 1
    run = run + 1 if bit == last and run else 1
    return (bit << 3 | min(run, 5)) << 8 | inserted


def _then(step: int, one: list[int], bit: int) -> int:
    """Combine a step of several bits with one more bit."""
    last = one[step & 0xF00 | bit]
    return last + (step & 0xF)


_CRC15_BLOCK = _crc15_table()
_STUFF_BLOCKS = _stuff_tables()
_CRC15 = _mem.shorts_of(_CRC15_BLOCK)
_STUFF1 = _mem.shorts_of(_STUFF_BLOCKS[1])
_STUFF3 = _mem.shorts_of(_STUFF_BLOCKS[3])
_STUFF4 = _mem.shorts_of(_STUFF_BLOCKS[4])
_STUFF5 = _mem.shorts_of(_STUFF_BLOCKS[5])
_STUFF7 = _mem.shorts_of(_STUFF_BLOCKS[7])
_STUFF8 = _mem.shorts_of(_STUFF_BLOCKS[8])
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
    """The number of bits from SOF to the end of EOF.

    `count` sums whole table entries: their low bytes are the stuff bits.
    """
    info = head >> 32
    identifier = head & 0x1FFFFFFF
    dlc = info >> 16 & 15
    remote = 1 if info & _REMOTE else 0
    length = 0 if remote else (dlc if dlc < 8 else 8)
    table = _STUFF8
    crc_table = _CRC15
    if info & _EXTENDED:  # SOF, base, SRR, IDE, extension, RTR, r1, r0, DLC: 39 bits
        header = (identifier >> 18 << 20 | 3 << 18 | identifier & 0x3FFFF) << 7 | remote << 6 | dlc
        bits = 64 + 8 * length
        step = _STUFF7[_START_STATE + (header >> 32)]
        count = step
        step = table[step & 0xF00 | header >> 24 & 255]
        count += step
        step = table[step & 0xF00 | header >> 16 & 255]
        count += step
        crc = crc_table[(length + 4) << 8 | header >> 32]
        crc ^= crc_table[(length + 3) << 8 | header >> 24 & 255]
        crc ^= crc_table[(length + 2) << 8 | header >> 16 & 255]
    else:  # SOF, base, RTR, IDE, r0, DLC: 19 bits
        header = identifier << 7 | remote << 6 | dlc
        bits = 44 + 8 * length
        step = _STUFF3[_START_STATE + (header >> 16)]
        count = step
        crc = crc_table[(length + 2) << 8 | header >> 16]
    step = table[step & 0xF00 | header >> 8 & 255]
    count += step
    crc ^= crc_table[(length + 1) << 8 | header >> 8 & 255]
    step = table[step & 0xF00 | header & 255]
    count += step
    crc ^= crc_table[length << 8 | header & 255]
    data = words[2]
    while length > 0:
        length -= 1
        step = table[step & 0xF00 | data & 255]
        count += step
        crc ^= crc_table[length << 8 | data & 255]
        data >>= 8
    step = _STUFF7[step & 0xF00 | crc >> 8]
    count += step
    step = table[step & 0xF00 | crc & 255]
    count += step
    if step & 0x700 == 0x500:
        count += 1
    return bits + (count & 255)


def _measure_fd(box: Mailbox, head: int, fd_mode: int) -> None:
    words = box.words
    info = head >> 32
    identifier = head & 0x1FFFFFFF
    dlc = info >> 16 & 15
    length = _LENGTHS[dlc]
    switch = 1 if info & _BIT_RATE_SWITCH else 0
    table = _STUFF8
    if info & _EXTENDED:  # SOF, base, SRR, IDE, extension, RRS, FDF, res, BRS: 36 bits
        header = (identifier >> 18 << 20 | 3 << 18 | identifier & 0x3FFFF) << 4 | 4 | switch
        bits = 41
        step = _STUFF4[_START_STATE + (header >> 32)]
        count = step
        step = table[step & 0xF00 | header >> 24 & 255]
        count += step
        step = table[step & 0xF00 | header >> 16 & 255]
        count += step
    else:  # SOF, base, RRS, IDE, FDF, res, BRS: 17 bits
        header = identifier << 5 | 4 | switch
        bits = 22
        step = _STUFF1[_START_STATE + (header >> 16)]
        count = step
    step = table[step & 0xF00 | header >> 8 & 255]
    count += step
    step = table[step & 0xF00 | header & 255]
    count += step
    nominal = bits - 5 + (count & 255)
    step = _STUFF5[step & 0xF00 | (16 if info & _ERROR_STATE else 0) | dlc]
    count += step
    at = 2
    left = length
    while left > 0:
        data = words[at]
        at += 1
        for _ in range(left if left < 8 else 8):
            step = table[step & 0xF00 | data & 255]
            count += step
            data >>= 8
        left -= 8
    crc_field = (27 if length <= 16 else 32) - (5 if fd_mode == _NON_ISO else 0)
    box.bits = bits + 8 * length + (count & 255) + crc_field + _TAIL_BITS
    box.data_bits = box.bits - _TAIL_BITS - nominal if switch else 0
