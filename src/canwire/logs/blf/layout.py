"""Numbers and structures of a BLF file; all little-endian."""

from __future__ import annotations

import struct
from datetime import UTC, datetime

MAGIC, OBJECT_MAGIC = b"LOGG", b"LOBJ"
HEAD_SIZE = 144
HEAD = struct.Struct("<4sI8BQQII8H8H72x")
BASE = struct.Struct("<4sHHII")  # magic, header's size, its version, object's size, type
TIMED = struct.Struct("<4sHHIIIHHQ")  # and flags, client, version, time stamp
TIMED_2 = struct.Struct("<IBxHQ8x")  # a header of version 2 behind its base
CONTAINER_HEAD = struct.Struct("<4sHHIIH6xI4x")
NO_COMPRESSION, ZLIB = 0, 2
TEN_MICROSECONDS, NANOSECONDS = 1, 2

CAN_MESSAGE, CAN_ERROR, CONTAINER, LIN_MESSAGE, LIN_MESSAGE_2 = 1, 2, 10, 11, 57
APP_TEXT, CAN_ERROR_EXT, CAN_MESSAGE_2, CAN_FD, CAN_FD_64 = 65, 73, 86, 100, 101

CAN = struct.Struct("<HBBI8s")  # channel, flags, DLC, identifier, data
FD = struct.Struct("<HBBIIBBB5x64s")  # frame's length, bit count, FD flags, valid bytes
FD_64 = struct.Struct("<BBBBIIIIIIIHBBI")
ERROR_EXT = struct.Struct("<HHIBBBxIIH2x8s")
LIN = struct.Struct("<HBB8s4BHBx")
TEXT = struct.Struct("<IIII")
SENT, REMOTE = 1, 0x80  # of a CAN message's flags
EXTENDED = 0x8000_0000
EDL, BRS, ESI = 1, 2, 4
EDL_64, BRS_64, ESI_64, REMOTE_64 = 0x1000, 0x2000, 0x4000, 0x10
OURS = "canwire "


_YEARS = range(1970, 2262)  # whose nanoseconds a record holds


def system_time(time_ns: int | None) -> tuple[int, ...]:
    """A date as eight numbers, to the millisecond (UTC, as python-can writes it); zeros for None."""
    if time_ns is None:
        return (0,) * 8
    moment = datetime.fromtimestamp(time_ns // 10**9, UTC)
    return (moment.year, moment.month, moment.isoweekday() % 7, moment.day, moment.hour, moment.minute,
            moment.second, time_ns // 10**6 % 1000)  # fmt: skip


def ns_of_system_time(numbers: tuple[int, ...]) -> int | None:
    """Return nanoseconds since 1970; None for zeros, for an invalid date, and for a date outside
    the range of records."""
    year, month, _, day, hour, minute, second, milli = numbers
    try:
        moment = datetime(year, month, day, hour, minute, second, tzinfo=UTC)
    except ValueError:
        return None
    return int(moment.timestamp()) * 10**9 + milli * 10**6 if year in _YEARS else None
