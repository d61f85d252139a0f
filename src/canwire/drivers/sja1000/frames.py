"""Frames as the bytes of an SJA1000's transmit buffer and receive window, PeliCAN layout.

Source: SJA1000 data sheet, tables 28 to 41; reference/sja1000.md section 8.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from canwire.bus.can.node import Mailbox
from canwire.chips.sja1000 import register_map as m

_RECORD = struct.Struct("<QII8s")  # of a record: time word, identifier, info, data
_REMOTE, _EXTENDED, _DLC_SHIFT = 1 << 22, 1 << 23, 16


def frame_bytes(box: Mailbox) -> bytes:
    """The bytes to write from m.TX_BUFFER on: frame information, identifier, data."""
    _, id, info, data = _RECORD.unpack_from(box.block)
    length = info >> _DLC_SHIFT & 15
    remote = m.FI_RTR if info & _REMOTE else 0
    if info & _EXTENDED:
        head = bytes((m.FI_FF | remote | length, id >> 21, id >> 13 & 0xFF, id >> 5 & 0xFF, (id & 31) << 3))
    else:
        head = bytes((remote | length, id >> 3, (id & 7) << 5))
    return head if remote else head + data[: min(length, 8)]


def take_frame(read: Callable[[int], int], box: Mailbox) -> None:
    """Copy the frame in the receive window into a mailbox; the window keeps it."""
    head = read(m.RX_WINDOW)
    if head & m.FI_FF:
        id = read(17) << 21 | read(18) << 13 | read(19) << 5 | read(20) >> 3
        at, info = 21, _EXTENDED
    else:
        id = read(17) << 3 | read(18) >> 5
        at, info = 19, 0
    length = head & m.FI_DLC_MASK
    info |= length << _DLC_SHIFT
    data = b""
    if head & m.FI_RTR:
        info |= _REMOTE
    else:
        data = bytes([read(k) for k in range(at, at + min(length, 8))])
    _RECORD.pack_into(box.block, 0, 0, id, info, data)
