"""Reads the plain log lines of a block together with numpy: `(seconds.micros) name ID#DATA[ R|T]`.

Each column of the text is gathered for all lines together; a line that contains anything else is returned as text.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from canwire.logs.batch import log_dtype
from canwire.logs.blocks.fields import NO_DIGIT, hex_digits
from canwire.values.record import DLC_SHIFT, EXTENDED, load_numpy

if TYPE_CHECKING:
    import numpy

    from canwire.logs.source import Source

_LONGEST_NAME = 16


def plain_lines(text: bytes, source: Source) -> tuple[numpy.ndarray, list[tuple[int, int, bytes]], int]:
    """Read the plain lines of a block.

    Returns their records; for each other line the number of records before it, its number and its text; and the number
    of lines."""
    numpy = load_numpy()
    block = numpy.frombuffer(text + b"\n" * 64, numpy.uint8)  # room to gather behind the last line
    ends = numpy.flatnonzero(block[: len(text)] == 10)
    if not text.endswith(b"\n"):
        ends = numpy.append(ends, len(text))
    starts = numpy.concatenate(([0], ends[:-1] + 1))
    lines = _Lines(block, starts, ends)
    records = lines.records()
    plain = lines.plain
    numbers = lines.channels(plain, source)
    records = records[plain]
    records["channel"] = numbers
    others = numpy.flatnonzero(~plain)
    before = numpy.cumsum(plain)[others] if len(others) else others
    listed = [
        (int(place), int(line), text[starts[line] : ends[line]])
        for place, line in zip(before, others, strict=True)
        if ends[line] > starts[line]
    ]
    return records, listed, len(ends)


class _Lines:
    """The lines of a block: their beginnings and ends, and which of them are `plain` by the checks so far."""

    def __init__(self, block: Any, starts: Any, ends: Any) -> None:
        numpy = load_numpy()
        self._block = block
        self._starts = starts
        self._close, one_close = self._only(41, starts, ends)
        self._hash, one_hash = self._only(35, starts, ends)
        self._ends = ends - (block[ends - 1] == 13)
        last = block[self._ends - 1]
        self._directed = (block[self._ends - 2] == 32) & ((last == 82) | (last == 84))
        self._direction = numpy.where(self._directed, numpy.where(last == 82, 1, 2), 0)
        self._stop = self._ends - 2 * self._directed
        self._extended = block[self._hash - 4] != 32
        self._digits = numpy.where(self._extended, 8, 3)
        self.plain = one_close & one_hash & (block[starts] == 40)
        self.plain &= (self._close < self._hash) & (block[self._close - 7] == 46)
        self.plain &= (self._close - starts > 8) & (self._close - starts <= 18)
        width = self._hash - self._digits - 3 - self._close  # of the name
        self.plain &= (width >= 1) & (width <= _LONGEST_NAME)
        blanks = numpy.flatnonzero(block[: ends[-1] if len(ends) else 0] <= 32)
        inside = numpy.searchsorted(blanks, self._ends) - numpy.searchsorted(blanks, starts)
        self.plain &= inside == 2 + self._directed  # none in the name
        self.plain &= (block[self._close + 1] == 32) & (block[self._hash - self._digits - 1] == 32)

    def _only(self, character: int, starts: Any, ends: Any) -> tuple[Any, Any]:
        """Return the place of this character in each line, and whether the line contains it exactly once."""
        numpy = load_numpy()
        places = numpy.flatnonzero(self._block[: ends[-1] if len(ends) else 0] == character)
        first = numpy.searchsorted(places, starts)
        behind = numpy.searchsorted(places, ends)
        there = behind - first == 1
        return numpy.where(there, numpy.append(places, 0)[numpy.where(there, first, 0)], starts + 9), there

    def records(self) -> Any:
        """Return a record for every line; the records of lines that are not plain are meaningless."""
        numpy = load_numpy()
        found = numpy.zeros(len(self._starts), log_dtype())
        found["time_ns"] = self._time_ns()
        found["id"] = self._identifiers()
        length = self._stop - self._hash - 1
        self.plain &= (length >= 0) & (length <= 16) & (length % 2 == 0)
        self._fill_data(found["data"], length)
        info = (length // 2).astype("u4") << DLC_SHIFT
        found["info"] = info | numpy.where(self._extended, EXTENDED, 0).astype("u4")
        found["direction"] = self._direction
        return found

    def channels(self, plain: Any, source: Source) -> Any:
        """Return the channel numbers of the plain lines."""
        numpy = load_numpy()
        begin = self._close[plain] + 2
        length = self._hash[plain] - self._digits[plain] - 1 - begin
        columns = [
            numpy.where(length > column, self._block[numpy.minimum(begin + column, len(self._block) - 1)], 0)
            for column in range(_LONGEST_NAME)
        ]
        names = (
            numpy.ascontiguousarray(numpy.stack(columns, 1).astype("u1"))
            if len(begin)
            else numpy.zeros((0, 16), "u1")
        )
        if not len(names) or (names == names[0]).all():
            firsts, which = numpy.arange(min(1, len(names))), numpy.zeros(len(names), "i8")
        else:
            _, firsts, which = numpy.unique(names.view("S16")[:, 0], return_index=True, return_inverse=True)
        numbers = numpy.zeros(len(firsts), "u2")
        for number, first in enumerate(firsts.tolist()):
            numbers[number] = source.channel(names[first].tobytes().rstrip(b"\0").decode("utf-8", "replace"))
        return numbers[which]

    def _time_ns(self) -> Any:
        numpy = load_numpy()
        seconds = numpy.zeros(len(self._starts), "i8")
        width = self._close - 7 - self._starts - 1  # of the seconds
        for column in range(9, -1, -1):
            digit = self._block[self._close - 8 - column] - numpy.uint8(48)
            there = width > column
            self.plain &= ~there | (digit < 10)
            seconds = seconds * 10 + numpy.where(there, digit, 0)
        micros = numpy.zeros(len(self._starts), "i8")
        for column in range(6):
            digit = self._block[self._close - 6 + column] - numpy.uint8(48)
            self.plain &= digit < 10
            micros = micros * 10 + digit
        return seconds * 10**9 + micros * 1000

    def _identifiers(self) -> Any:
        numpy = load_numpy()
        found = numpy.zeros(len(self._starts), "u4")
        for column in range(8, 0, -1):
            nibble = hex_digits()[self._block[self._hash - column]]
            there = self._digits >= column
            self.plain &= ~there | (nibble != NO_DIGIT)
            found = found << numpy.uint32(4) | numpy.where(there, nibble, 0).astype("u4")
        self.plain &= found <= numpy.where(self._extended, 0x1FFFFFFF, 0x7FF)  # else an error frame, or wrong
        return found

    def _fill_data(self, data: Any, length: Any) -> None:
        numpy = load_numpy()
        table = hex_digits()
        for column in range(8):
            there = length > 2 * column
            at = self._hash + 1 + 2 * column
            high, low = table[self._block[at]], table[self._block[at + 1]]
            self.plain &= ~there | ((high != NO_DIGIT) & (low != NO_DIGIT))
            data[:, column] = numpy.where(there, high << 4 | low & 15, 0)
