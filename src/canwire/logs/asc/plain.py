"""Reads ASC's most common line with numpy: `0.001234 1  123x  Rx   d 8 11 22 33 44 55 66 77 88`,
also with more text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from canwire.logs.batch import log_dtype
from canwire.logs.blocks.fields import Fields, fill_data
from canwire.values.record import DLC_SHIFT, EXTENDED, load_numpy

if TYPE_CHECKING:
    import numpy

_TIME, _CHANNEL, _ID, _DIRECTION, _KIND, _DLC, _DATA = range(7)
_LAST_S = 9_000_000_000


def candidates(fields: Fields) -> Any:
    """Select the lines that may be plain, by the number of words and the `d` of data."""
    kind = fields.at(_KIND, slice(None))
    return (fields.count > _DLC) & (kind.size == 1) & (kind.character(0) == ord("d"))


def changing(fields: Fields) -> Any:
    """Select the lines that begin with neither a digit nor a sign: headers and comments, which are no events."""
    first = fields.at(0, slice(None)).character(0)
    digit = ((first >= 48) & (first <= 57)) | (first == ord("-"))
    return ~digit & (fields.count > 0)


def records(fields: Fields, those: Any, zero_ns: int) -> tuple[numpy.ndarray, Any, Any]:
    """Return records of data frames with hex data, with times relative to `zero_ns`; a mask of the lines that
    really are such frames; and the channels' numbers."""
    numpy = load_numpy()
    found = numpy.zeros(len(those), log_dtype())
    time_ns, good = fields.at(_TIME, those).nanoseconds(9)
    good &= (time_ns < _LAST_S * 10**9 - zero_ns) & (time_ns >= -zero_ns)
    channel, fine = fields.at(_CHANNEL, those).decimal(4)
    good &= fine
    id = fields.at(_ID, those)
    extended = id.character(-1) == ord("x")
    identifier, fine = id.part(0, id.size - extended).hexadecimal(8)
    good &= fine & (identifier <= numpy.where(extended, 0x1FFFFFFF, 0x7FF))
    direction = fields.at(_DIRECTION, those)
    received, sent = direction.is_word(b"Rx"), direction.is_word(b"Tx")
    good &= received | sent
    code, fine = fields.at(_DLC, those).hexadecimal(1)
    good &= fine & fill_data(fields, those, _DATA, numpy.minimum(code, 8), found["data"])
    good &= (code <= 8) | (fields.count[those] <= _DATA + 8)
    found["time_ns"] = numpy.where(good, time_ns, 0) + zero_ns
    found["id"] = numpy.where(good, identifier, 0)
    found["info"] = code << DLC_SHIFT | numpy.where(extended, EXTENDED, 0)
    found["direction"] = numpy.where(received, 1, 2)
    return found, good, channel
