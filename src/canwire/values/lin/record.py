"""A LIN frame in the 80-byte record that every ring carries, and in VCI's 16-byte LINMSG.

    offset  size  field
    0       8     time_ns   received: end of frame; ticks in a queue that stamps with ticks
    8       4     pid       protected identifier; 0xFF for events
    12      4     info      LINMSGINFO: pid 0..7, type 8..15, dlen 16..23, ecs 24, sor 25, ovr 26, ido 27
    16      8     data      LINMSG's abData; events: see event.py
    24      1     checksum  of a frame; an event's state
    25      55              zeros, but for an event's identifier in the first

So LINMSG is made of bytes 0..3, 12..15 and 16..23.

Source: VCI V4 manual 7.4.5 and 7.4.6, reference/vci.md sections 4 and 5.
"""

from __future__ import annotations

import struct

from canwire.errors import BadFrame
from canwire.values.checks import octets
from canwire.values.lin.frame import LARGEST_LENGTH, LinFrame, checked_id
from canwire.values.record import RECORD_SIZE, STRUCT_LINMSG

NO_PID = 0xFF
TYPE_SHIFT = 8
LENGTH_SHIFT = 16
ENHANCED = 1 << 24
SENT = 1 << 25
OVERRUN = 1 << 26
ID_ONLY = 1 << 27

TIME_SIZE = 8
_TAIL = struct.Struct(f"<II8sB{RECORD_SIZE - 25}x")
_HEAD = struct.Struct("<QII8s")
_LINMSG = struct.Struct(STRUCT_LINMSG)
_M32 = 0xFFFF_FFFF


def record_of_lin_frame(frame: LinFrame) -> bytes:
    """The frame as 80 bytes of record; its time word is the frame's timestamp."""
    info = ENHANCED * frame.enhanced | SENT * frame.sent | OVERRUN * frame.overrun
    info |= ID_ONLY * frame.header_only
    info |= frame.pid | frame.length << LENGTH_SHIFT
    checksum = 0 if frame.header_only else frame.checksum
    return frame.timestamp_ns.to_bytes(TIME_SIZE, "little") + record_tail(info, frame.data, checksum)


def record_tail(info: int, data: bytes, checksum: int) -> bytes:
    """The 72 bytes of a frame's record after its time."""
    return _TAIL.pack(info & 0xFF, info, data, checksum)


def lin_frame_of_record(record: bytes | bytearray | memoryview) -> LinFrame:
    """The frame in 80 bytes of record; raises BadFrame if it holds none that could be.

    An identifier may come without its parity bits.
    """
    time_ns, _, info, data = _HEAD.unpack_from(_record("record", record))
    return _frame(time_ns, info, data)


def linmsg_of_record(record: bytes | bytearray | memoryview) -> bytes:
    """VCI's LINMSG of a record, frame or event; its time is the record's time word, cut to 32 bits.

    Raises BadFrame for what is no record of 80 bytes.
    """
    time, _, info, data = _HEAD.unpack_from(_record("record", record))
    return _LINMSG.pack(time & _M32, info, data)


def record_of_linmsg(message: bytes | bytearray | memoryview) -> bytes:
    """A LINMSG as a record; raises BadFrame for another size. What it says is checked where it is used."""
    message = octets("message", message)
    if len(message) != _LINMSG.size:
        raise BadFrame(f"a LINMSG has {_LINMSG.size} bytes, not {len(message)}")
    time, info, data = _LINMSG.unpack(message)
    return time.to_bytes(TIME_SIZE, "little") + record_tail(info, data, 0)


def message_type(record: bytes | bytearray | memoryview) -> int:
    """The type of a message: 0 for a frame, else the number of a LinEventKind, which may be unknown."""
    return record[13]


def _record(name: str, record: bytes | bytearray | memoryview) -> bytes:
    content = octets(name, record)
    if len(content) != RECORD_SIZE:
        raise BadFrame(f"a record has {RECORD_SIZE} bytes, not {len(content)}")
    return content


def _frame(time_ns: int, info: int, data: bytes) -> LinFrame:
    if info >> TYPE_SHIFT & 0xFF:
        raise BadFrame(f"message type {info >> TYPE_SHIFT & 0xFF}: a frame has type 0")
    length = info >> LENGTH_SHIFT & 0xFF
    if length > LARGEST_LENGTH:
        raise BadFrame(f"{length} bytes: a LIN frame carries at most 8")
    header_only = info & ID_ONLY != 0
    return LinFrame(
        checked_id(info & 0xFF),
        b"" if header_only else data[:length],
        enhanced=info & ENHANCED != 0,
        header_only=header_only,
        length=length,
        timestamp_ns=time_ns,
        sent=info & SENT != 0,
        overrun=info & OVERRUN != 0,
    )
