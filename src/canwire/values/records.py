"""Many frames as numpy records, with the checks of Frame for all of them together."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING

from canwire.errors import BadFrame
from canwire.values.checks import instance
from canwire.values.dlc import CLASSIC_LENGTHS, FD_LENGTHS
from canwire.values.frame import Frame, record_of_frame
from canwire.values.record import (
    DLC_SHIFT,
    ERROR_STATE_INDICATOR,
    EXTENDED,
    EXTENDED_DATA_LENGTH,
    FAST_DATA_RATE,
    RECORD_SIZE,
    REMOTE,
    load_numpy,
    record_dtype,
)

if TYPE_CHECKING:
    import numpy

_PLAIN = f"V{RECORD_SIZE}"  # bytes: numpy copies records of several fields field by field
_OF_FD, _OF_REMOTE = 16, 32
_FD_ONLY = FAST_DATA_RATE | ERROR_STATE_INDICATOR
_FRAME_INFO = (
    EXTENDED | REMOTE | EXTENDED_DATA_LENGTH | FAST_DATA_RATE | ERROR_STATE_INDICATOR | 0xF << DLC_SHIFT
)


def frames_to_array(frames: Iterable[Frame]) -> numpy.ndarray:
    """Frames as records of `record_dtype()` for `send_array`; timestamps become 0. Needs canwire[arrays]."""
    listed = list(frames)
    for frame in listed:
        if frame.__class__ is not Frame:
            instance("frame", frame, Frame)
    array = load_numpy().frombuffer(bytearray(b"".join(map(record_of_frame, listed))), record_dtype())
    array["time_ns"] = 0
    return array


def check_dtype(records: numpy.ndarray) -> None:
    """Raise TypeError unless this is a one-dimensional array of `record_dtype()`."""
    numpy = load_numpy()
    instance("records", records, numpy.ndarray)
    if records.dtype != record_dtype() or records.ndim != 1:
        raise TypeError(
            f"records {records.dtype} in {records.ndim} dimensions: record_dtype() in a row is needed"
        )


def checked_records(records: numpy.ndarray, *, fd: bool, flags: int) -> numpy.ndarray:
    """A copy ready to send: info reduced to the bits of the frame plus `flags`, bytes after the data set to 0.

    Raises BadFrame with the first invalid record, TypeError for another dtype.
    """
    numpy = load_numpy()
    check_dtype(records)
    info = records["info"] & _FRAME_INFO
    is_fd = info & EXTENDED_DATA_LENGTH != 0
    limits = numpy.where(info & EXTENDED, numpy.uint32(0x1FFFFFFF), numpy.uint32(0x7FF))
    faults = {
        "identifier too large for its format": records["id"] > limits,
        "FD frame on a classic line": is_fd & (not fd),
        "remote frame that is FD": is_fd & (info & REMOTE != 0),
        "no data or remote frame": records["info"] & 0xFF != 0,
        "bit-rate switch or error indicator without FD": ~is_fd
        & (info & (FAST_DATA_RATE | ERROR_STATE_INDICATOR) != 0),
    }
    for what, wrong in faults.items():
        if wrong.any():
            at = int(wrong.argmax())
            raise BadFrame(f"record {at} (identifier {int(records['id'][at]):#x}): {what}")
    checked = records.view(_PLAIN).copy().view(record_dtype())
    checked["info"] = info | flags
    data = checked.view("<u8").reshape(-1, 10)[:, 2:]
    kinds = info >> DLC_SHIFT & 15 | numpy.where(info & REMOTE, _OF_REMOTE, 0)
    if is_fd.any():
        data &= _kept_bytes()[kinds | numpy.where(is_fd, _OF_FD, 0)]
    else:
        data[:, 0] &= _kept_bytes()[:, 0][kinds]
        data[:, 1:] = 0
    return checked


@cache
def _kept_bytes() -> numpy.ndarray:
    """Masks over a record's eight words of data, by its DLC, _OF_FD and _OF_REMOTE."""
    numpy = load_numpy()
    none = [0] * 16
    lengths = numpy.array([*CLASSIC_LENGTHS, *FD_LENGTHS, *none, *none])
    kept = (numpy.arange(64) < lengths[:, None]) * numpy.uint8(0xFF)
    return kept.view("<u8")
