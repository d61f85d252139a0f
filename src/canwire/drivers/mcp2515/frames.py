"""Frames as the thirteen bytes of an MCP2515's buffers: identifier, length, data.

Source: DS20001801 registers 3-3 to 3-8 and 4-4 to 4-9.
"""

from __future__ import annotations

import struct

from canwire.bus.can.node import Mailbox
from canwire.chips.mcp2515 import register_map as m

_RECORD = struct.Struct("<QII8s")  # of a record: time word, identifier, info, data
_HEAD = struct.Struct("<QII")
_REMOTE, _EXTENDED, _DLC_SHIFT = 1 << 22, 1 << 23, 16
_RTR, _SRR, _EXIDE = m.DLC_RTR, m.SIDL_SRR, m.SIDL_EXIDE


def frame_bytes(box: Mailbox) -> bytes:
    """The bytes to load into a transmit buffer, from TXBnSIDH on."""
    _, id, info, data = _RECORD.unpack_from(box.block)
    length = info >> _DLC_SHIFT & 15
    remote = _RTR if info & _REMOTE else 0
    if info & _EXTENDED:
        low = id >> 13 & 0xE0 | _EXIDE | id >> 16 & 3
        head = bytes((id >> 21, low, id >> 8 & 0xFF, id & 0xFF, length | remote))
    else:
        head = bytes((id >> 3, (id & 7) << 5, 0, 0, length | remote))
    return head if remote else head + data[: length if length < 8 else 8]


def take_frame(read: bytes, box: Mailbox) -> None:
    """Put a received frame, the bytes from RXBnSIDH on, into a mailbox."""
    high, low, eid8, eid0, length = read[:5]
    id = high << 3 | low >> 5
    info = (length & 15) << _DLC_SHIFT
    if low & _EXIDE:
        id = id << 18 | (low & 3) << 16 | eid8 << 8 | eid0
        info |= _EXTENDED
        remote = length & _RTR
    else:
        remote = low & _SRR
    data = b""
    if remote:
        info |= _REMOTE
    else:
        data = read[5 : 5 + (length & 15 if length & 15 < 8 else 8)]
    _RECORD.pack_into(box.block, 0, 0, id, info, data)


def arbitration_key(box: Mailbox) -> int:
    """The frame's arbitration field: of two frames, the one with the lower key wins arbitration."""
    _, id, info = _HEAD.unpack_from(box.block)
    remote = 1 if info & _REMOTE else 0
    if info & _EXTENDED:
        return (id >> 18) << 21 | 0x180000 | (id & 0x3FFFF) << 1 | remote
    return int(id << 21 | remote << 20)
