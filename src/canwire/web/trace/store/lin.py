"""Rows of LIN lines together with CAN rows: one byte distinguishes them, and the rest of a record is unchanged.

Byte 12 of a LIN record is the protected identifier, byte 13 its type (0: a frame). In a row these bytes are exchanged,
and LIN is added to the type, which no kind of a CAN record contains.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy

from canwire import LinEvent, LinFrame, lin_frame_of_record, record_dtype

if TYPE_CHECKING:
    from numpy.typing import NDArray

LIN = 0x20
_TYPE = 0x1F
_PID_AT, _TYPE_AT = 12, 13


def rows_of_lin(records: numpy.ndarray) -> numpy.ndarray:
    """Convert records of a monitor to rows."""
    octets: NDArray[numpy.uint8] = records.view(numpy.uint8).reshape(len(records), records.itemsize).copy()
    octets[:, [_PID_AT, _TYPE_AT]] = octets[:, [_TYPE_AT, _PID_AT]]
    octets[:, _PID_AT] |= LIN
    return octets.view(record_dtype()).reshape(-1)


def is_lin(kind: int) -> bool:
    """Whether a row of this kind is of a LIN line."""
    return kind & ~_TYPE == LIN


def lin_message(record: bytes) -> LinFrame | LinEvent:
    """Convert a LIN row's record to a frame or event; raises ValueError, BadFrame for an invalid record."""
    kind, pid = record[_PID_AT] & _TYPE, record[_TYPE_AT]
    plain = record[:_PID_AT] + bytes((pid, kind)) + record[_TYPE_AT + 1 :]
    return LinEvent.from_record(plain) if kind else lin_frame_of_record(plain)


def plain_lin(records: numpy.ndarray) -> numpy.ndarray:
    """Convert rows of LIN lines to the records of a monitor."""
    octets: NDArray[numpy.uint8] = records.view(numpy.uint8).reshape(len(records), records.itemsize).copy()
    octets[:, _PID_AT] &= _TYPE
    octets[:, [_PID_AT, _TYPE_AT]] = octets[:, [_TYPE_AT, _PID_AT]]
    return octets.view(record_dtype()).reshape(-1)
