"""Frames in an MCP2515's buffers: from the bytes of a transmit buffer, to those of a receive buffer.

Source: DS20001801 registers 3-3 to 3-8 and 4-4 to 4-9.
"""

from __future__ import annotations

import struct

from canwire.bus.can.node import Mailbox
from canwire.chips.mcp2515 import register_map as m

RECORD = struct.Struct("<QII8s")  # of a record: time word, identifier, info, data
REMOTE, EXTENDED, DLC_SHIFT = 1 << 22, 1 << 23, 16


def compose(box: Mailbox, cells: bytearray, at: int) -> None:
    """Write the frame in the transmit buffer whose control register is at `at` to the record of `box`."""
    high, low, eid8, eid0, length = cells[at + m.SIDH : at + m.DATA]
    info = (length & m.DLC_MASK) << DLC_SHIFT
    id = high << 3 | low >> 5
    if low & m.SIDL_EXIDE:
        id = id << 18 | (low & 3) << 16 | eid8 << 8 | eid0
        info |= EXTENDED
    data = b""
    if length & m.DLC_RTR:
        info |= REMOTE
    else:
        data = bytes(cells[at + m.DATA : at + m.DATA + min(length & m.DLC_MASK, 8)])
    RECORD.pack_into(box.block, 0, 0, id, info, data)


def head_of(id: int, info: int) -> bytes:
    """Identifier and length of a frame in the form of a receive buffer."""
    length = info >> DLC_SHIFT & 15
    if info & EXTENDED:
        length |= m.DLC_RTR if info & REMOTE else 0
        low = id >> 13 & 0xE0 | m.SIDL_EXIDE | id >> 16 & 3
        return bytes((id >> 21, low, id >> 8 & 0xFF, id & 0xFF, length))
    return bytes((id >> 3, (id & 7) << 5 | (m.SIDL_SRR if info & REMOTE else 0), 0, 0, length))
