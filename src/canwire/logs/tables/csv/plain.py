"""Reads the most common row of canwire's CSV with numpy:
`1.000250000,can0,R,CAN_FRAME,123,0,0,0,0,0,8,1122334455667788,`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from canwire.logs.batch import log_dtype
from canwire.logs.blocks.fields import Column, Fields
from canwire.logs.tables.columns import FLAGS, lengths_of
from canwire.values.record import DLC_SHIFT, EXTENDED, load_numpy

if TYPE_CHECKING:
    import numpy

_TIME, _CHANNEL, _DIRECTION, _TYPE, _ID, _FLAGS, _DLC, _DATA, _DETAIL = 0, 1, 2, 3, 4, 5, 10, 11, 12
_COLUMNS = 13
_LONGEST_NAME = 16
_LAST_S = 9_000_000_000


def candidates(fields: Fields) -> Any:
    """Select the lines that may be plain, by the number of cells."""
    return fields.count == _COLUMNS


def records(fields: Fields, those: Any) -> tuple[numpy.ndarray, Any, Any]:
    """Return records of CAN frames, a mask of the valid rows, and the names of their channels as bytes."""
    numpy = load_numpy()
    found = numpy.zeros(len(those), log_dtype())
    time_ns, good = fields.at(_TIME, those).nanoseconds(9)
    good &= time_ns < _LAST_S * 10**9
    good &= fields.at(_TYPE, those).is_word(b"CAN_FRAME") & (fields.at(_DETAIL, those).size == 0)
    direction = fields.at(_DIRECTION, those)
    received, sent = direction.is_word(b"R"), direction.is_word(b"T")
    good &= received | sent | (direction.size == 0)
    identifier, fine = fields.at(_ID, those).hexadecimal(8)
    code, valid = fields.at(_DLC, those).decimal(2)
    info, flagged = _flags(fields, those)
    good &= fine & valid & flagged & (code <= 15)
    good &= identifier <= numpy.where(info & EXTENDED, 0x1FFFFFFF, 0x7FF)
    found["time_ns"] = numpy.where(good, time_ns, 0)
    found["id"] = numpy.where(good, identifier, 0)
    found["info"] = info | numpy.where(good, code, 0) << DLC_SHIFT
    found["direction"] = numpy.where(received, 1, numpy.where(sent, 2, 0))
    length = numpy.where(good, lengths_of(found), 0)
    data = fields.at(_DATA, those)
    good &= (data.size == 2 * length) & data.bytes_in_hex(found["data"], length)
    keys, fine = _names(fields.at(_CHANNEL, those))
    return found, good & fine, keys


def _flags(fields: Fields, those: Any) -> tuple[Any, Any]:
    """Return extended, remote, fd, brs, esi as bits of info, and a mask of the rows with a valid combination."""
    numpy = load_numpy()
    info, good = numpy.zeros(len(those), "u4"), numpy.ones(len(those), bool)
    is_set = {}
    for at, (name, bit) in enumerate(FLAGS.items()):
        flag = fields.at(_FLAGS + at, those)
        is_set[name] = flag.is_word(b"1")
        good &= is_set[name] | flag.is_word(b"0")
        info |= numpy.where(is_set[name], numpy.uint32(bit), numpy.uint32(0))
    good &= ~(is_set["fd"] & is_set["remote"]) & (is_set["fd"] | ~(is_set["brs"] | is_set["esi"]))
    return info, good


def _names(channel: Column) -> tuple[Any, Any]:
    numpy = load_numpy()
    letters = numpy.zeros((len(channel.size), _LONGEST_NAME), "u1")
    for place in range(int(min(channel.size.max(initial=0), _LONGEST_NAME))):
        letters[:, place] = numpy.where(channel.size > place, channel.character(place), 0)
    good = channel.size <= _LONGEST_NAME
    return letters.view(f"S{_LONGEST_NAME}")[:, 0], good
