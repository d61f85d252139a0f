"""Reads TRC's most common line with numpy, in any columns: `1 0.123 DT 1 0123 Rx - 8 11 22 33 44 55 66 77 88`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from canwire.logs.batch import log_dtype
from canwire.logs.blocks.fields import Fields, fill_data
from canwire.values.record import DLC_SHIFT, EXTENDED, load_numpy

if TYPE_CHECKING:
    import numpy

_LAST_MS = 9_000_000_000_000


def changing(fields: Fields) -> Any:
    """Select comments, some of which are headers, and lines that may begin with a blank that is not ASCII."""
    first = fields.at(0, slice(None)).character(0)
    return ((first == ord(";")) | (first >= 127)) & (fields.count > 0)


def candidates(fields: Fields, columns: Sequence[str]) -> Any:
    """The lines that may be plain, by the number of words; none if the order of columns is not the default."""
    usual = columns[-1] == "D" and "O" in columns and "I" in columns and ("L" in columns or "l" in columns)
    return (fields.count >= len(columns) - 1) & usual & ~changing(fields)


def records(
    fields: Fields, those: Any, columns: Sequence[str], zero_ns: int
) -> tuple[numpy.ndarray, Any, Any]:
    """Return records of data frames, with times relative to `zero_ns`; a mask of the lines that really are data frames;
    and the channels' numbers from 1 on."""
    numpy = load_numpy()
    found = numpy.zeros(len(those), log_dtype())
    column = {name: fields.at(at, those) for at, name in enumerate(columns[:-1])}
    span, good = _offset(column["O"])
    good &= (span < _LAST_MS * 10**6 - zero_ns) & (span >= -zero_ns)
    directions, fine = _directions(column, len(those))
    id = column["I"]
    identifier, valid = id.hexadecimal(8)
    extended = id.size > 4
    good &= fine & valid & (identifier <= numpy.where(extended, 0x1FFFFFFF, 0x7FF))
    code, fine = column["l" if "l" in columns else "L"].decimal(2)
    good &= fine & (code <= (8 if "l" in columns else 15))
    length = numpy.where(good, numpy.minimum(code, 8), 0)
    good &= fill_data(fields, those, len(columns) - 1, length, found["data"])
    good &= fields.count[those] == len(columns) - 1 + length
    channel = numpy.ones(len(those), "i8")
    if "B" in columns:
        channel, fine = column["B"].decimal(4)
        good &= fine
    found["time_ns"] = numpy.where(good, span, 0) + zero_ns
    found["id"] = numpy.where(good, identifier, 0)
    found["info"] = numpy.where(good, code, 0) << DLC_SHIFT | numpy.where(extended, EXTENDED, 0)
    found["direction"] = directions
    return found, good, channel


def _offset(offset: Any) -> tuple[Any, Any]:
    """Convert milliseconds, with or without decimals, to nanoseconds; also returns a mask of the valid ones."""
    numpy = load_numpy()
    exact, good = offset.nanoseconds(6)
    whole, fine = offset.decimal(12)
    return numpy.where(good, exact, whole * 10**6), good | fine


def _directions(column: dict[str, Any], count: int) -> tuple[Any, Any]:
    """Return directions (1 received, 2 sent, 0 unknown), and a mask of the lines that are data frames."""
    numpy = load_numpy()
    told = column.get("d" if "T" in column else "Y")
    data = column["T"].is_word(b"DT") if "T" in column else numpy.ones(count, bool)
    if told is None:
        return numpy.zeros(count, "u1"), data
    received, sent = told.is_word(b"Rx"), told.is_word(b"Tx")
    return numpy.where(received, 1, 2), data & (received | sent)
