"""The kind, identifier, length and direction of rows, for many rows at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy

from canwire.web.trace.store.lin import LIN

if TYPE_CHECKING:
    from numpy.typing import NDArray

Mask: TypeAlias = "NDArray[numpy.bool_]"
Test = Callable[[numpy.ndarray], Mask]
EXTENDED, REMOTE, FD = 1 << 23, 1 << 22, 1 << 10  # of the info word
_SENT, _LIN_SENT = 1 << 21, 1 << 25
_LENGTHS = numpy.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64])


def kind_of(rows: numpy.ndarray) -> NDArray[numpy.uint32]:
    found: NDArray[numpy.uint32] = rows["record"]["info"] & numpy.uint32(0xFF)
    return found


def is_lin(rows: numpy.ndarray) -> Mask:
    return (kind_of(rows) & 0xE0) == LIN


def is_frame(rows: numpy.ndarray) -> Mask:
    """Select data and remote frames, of CAN or LIN."""
    return (kind_of(rows) & ~numpy.uint32(LIN)) == 0


def is_error(rows: numpy.ndarray) -> Mask:
    return (kind_of(rows) & ~numpy.uint32(LIN)) == 2


def is_mark(rows: numpy.ndarray) -> Mask:
    """Select rows that report missing data; every filter lets them pass."""
    return kind_of(rows) >= 0xF0


def is_sent(rows: numpy.ndarray) -> Mask:
    bits = numpy.where(is_lin(rows), numpy.uint32(_LIN_SENT), numpy.uint32(_SENT))
    return (rows["record"]["info"] & bits != 0) & is_frame(rows)


def identifiers(rows: numpy.ndarray) -> NDArray[numpy.uint32]:
    """Identifiers of frames; for LIN, taken from the protected identifier."""
    info = rows["record"]["info"]
    found: NDArray[numpy.uint32] = numpy.where(is_lin(rows), info >> 8 & 0x3F, rows["record"]["id"])
    return found


def lengths(rows: numpy.ndarray) -> NDArray[numpy.int64]:
    """Return the number of data bytes."""
    info = rows["record"]["info"]
    code = info >> 16 & 15
    length = numpy.where(info & FD != 0, _LENGTHS[code], numpy.minimum(code, 8))
    length[(info & REMOTE != 0) & ~is_lin(rows)] = 0
    length[~is_frame(rows)] = 0
    return length
