"""Converts batches of frames between the hub's records and the messages on the sockets to the shim.

A received message is a header and a `struct can_frame` (16 bytes) or `canfd_frame` (72); a sent one has the same form
with a smaller header: `struct received` and `struct sent` of shim/shim.h.
"""

from __future__ import annotations

import struct
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

from canwire import record_dtype
from canwire.socketcan.constants import (
    CAN_EFF_FLAG,
    CAN_EFF_MASK,
    CAN_ERR_FLAG,
    CAN_MTU,
    CAN_RTR_FLAG,
    CAN_SFF_MASK,
    CANFD_BRS,
    CANFD_ESI,
    CANFD_MTU,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy

    Array = numpy.ndarray

HEADER_SIZE = 24
_SENT = struct.Struct("<iI")  # shim/shim.h, struct sent
SENT_HEADER_SIZE = 8
LOCAL, OWN = 1, 2  # flags of a received message: MSG_DONTROUTE, MSG_CONFIRM

# info bits of a record (see canwire.record_dtype)
_EXTENDED, REMOTE, _FD, _BRS, _ESI = 1 << 23, 1 << 22, 1 << 10, 1 << 11, 1 << 12
SELF_RECEPTION = 1 << 21
TYPE_MASK = 0xFF
_DLC_SHIFT = 16
IDENTITY = _EXTENDED | REMOTE | _FD | _BRS | _ESI | 0xF << _DLC_SHIFT
_NOT_PLAIN = CAN_RTR_FLAG | 0xFF << 56  # of a sent row's second word: a remote frame, or with a raw_dlc
_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)


class Batch:
    """Frames and events of a line, in order. `owners`: slots of the sockets that sent each frame, else -1.

    `errors` is a mask of the error frames; None: there is none. `rows` (received_dtype) are made on first use.
    """

    def __init__(self, make: Callable[[], Array], owners: Array, errors: Array | None) -> None:
        self._make = make
        self.owners = owners
        self.errors = errors

    @cached_property
    def rows(self) -> Array:
        return self._make()


_FRAME_FIELDS = [
    ("can_id", "<u4"),
    ("len", "u1"),
    ("fd_flags", "u1"),
    ("reserved", "u1"),
    ("raw_dlc", "u1"),
    ("data", "u1", 64),
]


@cache
def numpy_module() -> Any:
    """numpy; if it is missing, record_dtype raises an error that says so."""
    record_dtype()
    import numpy

    return numpy


@cache
def received_dtype() -> Any:
    """96 bytes: the form in which the server sends frames; bytes after a short frame are not sent."""
    header = [
        ("stamp_ns", "<u8"),
        ("drops", "<u4"),
        ("interface", "<i4"),
        ("flags", "<u2"),
        ("error", "<u2"),
        ("length", "<u4"),
    ]
    return numpy_module().dtype(header + _FRAME_FIELDS)


@cache
def sent_dtype() -> Any:
    """80 bytes: the form in which the frames of programs arrive."""
    return numpy_module().dtype([("interface", "<i4"), ("size", "<u4"), *_FRAME_FIELDS])


@cache
def _length_of_dlc() -> Array:
    found: Array = numpy_module().array(_LENGTHS, "u1")
    return found


@cache
def _dlc_of_length() -> Array:
    """By length 0..64, the next larger one that a frame can have."""
    codes = [next(code for code, size in enumerate(_LENGTHS) if size >= length) for length in range(65)]
    found: Array = numpy_module().array(codes, "u4")
    return found


def frames_received(records: Array, interface: int, epoch_ns: int) -> Array:
    """Frames' records (no events) as messages; flags, drops and errors are left 0."""
    numpy = numpy_module()
    found: Array = numpy.zeros(len(records), received_dtype())
    info = records["info"]
    is_fd = info & _FD != 0
    dlc = info >> _DLC_SHIFT & 15
    found["stamp_ns"] = records["time_ns"] + numpy.uint64(epoch_ns)
    found["interface"] = interface
    found["can_id"] = (
        records["id"] | (info & _EXTENDED) << 8 | (info & REMOTE) << 8
    )  # bits 23 and 22 to 31 and 30
    if is_fd.any():
        found["length"] = numpy.where(is_fd, CANFD_MTU, CAN_MTU)
        found["len"] = numpy.where(is_fd, _length_of_dlc()[dlc], numpy.minimum(dlc, 8))
        found["fd_flags"] = numpy.where(is_fd, info >> 11 & 3, 0)  # BRS and ESI are neighbours in both
        found["raw_dlc"] = numpy.where(is_fd | (dlc <= 8), 0, dlc)
    else:
        found["length"] = CAN_MTU
        found["len"] = numpy.minimum(dlc, 8)
        found["raw_dlc"] = numpy.where(dlc > 8, dlc, 0)
    found["data"] = records["data"]
    return found


def records_to_send(frames: Array) -> Array:
    """Messages from programs as records for `send_array`; `can_id`, `len` and `size` must have been checked."""
    numpy = numpy_module()
    found: Array = numpy.zeros(len(frames), record_dtype())
    words = frames.view("<u8").reshape(-1, 10)
    if not ((words[:, 0] >> 32 != CAN_MTU) | (words[:, 1] & _NOT_PLAIN != 0)).any():
        _plain_to_send(words, found.view("<u8").reshape(-1, 10))
        return found
    can_id = frames["can_id"]
    extended = can_id & CAN_EFF_FLAG != 0
    remote = can_id & CAN_RTR_FLAG != 0
    is_fd = frames["size"] == CANFD_MTU
    raw = frames["raw_dlc"].astype("u4")
    long_code = ~is_fd & (frames["len"] == 8) & (raw > 8) & (raw < 16)
    dlc = numpy.where(long_code, raw, _dlc_of_length()[frames["len"]])
    info = (can_id >> 8 & (_EXTENDED | REMOTE)) | dlc << _DLC_SHIFT
    flags = frames["fd_flags"].astype("u4") & (CANFD_BRS | CANFD_ESI)
    found["info"] = numpy.where(is_fd, info & ~numpy.uint32(REMOTE) | _FD | flags << 11, info)
    found["id"] = numpy.where(extended, can_id & CAN_EFF_MASK, can_id & CAN_SFF_MASK)
    lengths = numpy.where(remote & ~is_fd, 0, frames["len"])
    found["data"] = numpy.where(numpy.arange(64) < lengths[:, None], frames["data"], 0)
    return found


def _plain_to_send(rows: Array, records: Array) -> None:
    """Classic data frames whose DLC is their length, as 64-bit words: fields of rows take twice the time."""
    numpy = numpy_module()
    head = rows[:, 1]
    extended = head & CAN_EFF_FLAG
    length = head >> 32 & 0xFF
    identifier = head & numpy.where(extended, CAN_EFF_MASK, CAN_SFF_MASK).astype("u8")
    records[:, 1] = identifier | extended << 24 | length << 48
    records[:, 2] = rows[:, 2] & _bytes_of_length()[length]


@cache
def _bytes_of_length() -> Array:
    """By length 0..8, the ones in a word of data."""
    found: Array = numpy_module().array([(1 << 8 * length) - 1 for length in range(9)], "u8")
    return found


def keep_remote_data(records: Array, frames: Array) -> None:
    """Copy the data that programs wrote into remote frames, which no bus carries, to these records."""
    remote = records["info"] & REMOTE != 0
    if remote.any():
        records["data"][remote, :8] = frames["data"][remote, :8]


def row_of(frame: bytes, index: int) -> Array:
    """One row of `sent_dtype` of a struct can_frame or canfd_frame for this interface."""
    packed = _SENT.pack(index, len(frame)) + frame.ljust(CANFD_MTU, b"\0")
    found: Array = numpy_module().frombuffer(bytearray(packed), sent_dtype())
    return found


def sound(frames: Array) -> Array:
    """A mask of the valid frames among those of programs: the shim checks them, but belongs to the program."""
    size, length = frames["size"], frames["len"]
    classic = (size == CAN_MTU) & (length <= 8)
    fd = (size == CANFD_MTU) & (length <= 64)
    found: Array = (classic | fd) & (frames["can_id"] & CAN_ERR_FLAG == 0)
    return found
