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
_BEFORE, _BEHIND = 16, 64  # bytes around the lines: room to gather from


def plain_lines(text: bytes, source: Source) -> tuple[numpy.ndarray, list[tuple[int, int, bytes]], int]:
    """Read the plain lines of a block.

    Returns their records; for each other line the number of records before it, its number and its text; and the number
    of lines."""
    numpy = load_numpy()
    padded = numpy.frombuffer(b"\n" * _BEFORE + text + b"\n" * _BEHIND, numpy.uint8)
    block = padded[_BEFORE:]
    ends = numpy.flatnonzero(block[: len(text)] == 10)
    if not text.endswith(b"\n"):
        ends = numpy.append(ends, len(text))
    starts = numpy.concatenate(([0], ends[:-1] + 1))
    lines = _Lines(padded, starts, ends)
    records = lines.records()
    plain = lines.plain
    numbers = lines.channels(plain, source)
    others = numpy.flatnonzero(~plain)
    if len(others):
        records = records[plain]
    records["channel"] = numbers
    before = numpy.cumsum(plain)[others] if len(others) else others
    listed = [
        (int(place), int(line), text[starts[line] : ends[line]])
        for place, line in zip(before, others, strict=True)
        if ends[line] > starts[line]
    ]
    return records, listed, len(ends)


class _Lines:
    """The lines of a block: their beginnings and ends, and which of them are `plain` by the checks so far."""

    def __init__(self, padded: Any, starts: Any, ends: Any) -> None:
        numpy = load_numpy()
        self._padded = padded
        self._block = block = padded[_BEFORE:]
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
        self.plain &= self._blanks(ends) == 2 + self._directed  # none in the name
        self.plain &= (block[self._close + 1] == 32) & (block[self._hash - self._digits - 1] == 32)

    def _only(self, character: int, starts: Any, ends: Any) -> tuple[Any, Any]:
        """Return the place of this character in each line, and whether the line contains it exactly once."""
        numpy = load_numpy()
        places = numpy.flatnonzero(self._block[: ends[-1] if len(ends) else 0] == character)
        if len(places) == len(starts) and (places >= starts).all() and (places < ends).all():
            return places, numpy.ones(len(starts), bool)
        first = numpy.searchsorted(places, starts)
        behind = numpy.searchsorted(places, ends)
        there = behind - first == 1
        return numpy.where(there, numpy.append(places, 0)[numpy.where(there, first, 0)], starts + 9), there

    def _blanks(self, ends: Any) -> Any:
        """Return the number of blanks and control characters in each line, without its end."""
        numpy = load_numpy()
        places = numpy.flatnonzero(self._block[: ends[-1] + 1 if len(ends) else 0] <= 32)
        line_feeds = numpy.flatnonzero(self._block[places] == 10)
        return numpy.diff(line_feeds, prepend=-1) - 1 - (ends - self._ends)

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
        longest = int(length.max(initial=1))
        names = numpy.where(_counted(longest) < length, self._columns(begin, longest), 0)
        if (names == names[:, :1]).all():
            firsts, which = numpy.arange(min(1, len(begin))), numpy.zeros(len(begin), "i8")
        else:
            texts = numpy.ascontiguousarray(names.T).view(f"S{longest}")[:, 0]
            _, firsts, which = numpy.unique(texts, return_index=True, return_inverse=True)
        numbers = numpy.zeros(len(firsts), "u2")
        for number, first in enumerate(firsts.tolist()):
            name = names[:, first].tobytes().rstrip(b"\0")
            numbers[number] = source.channel(name.decode("utf-8", "replace"))
        return numbers[which]

    def _columns(self, begin: Any, count: int) -> Any:
        """Return the `count` characters from `begin` on of each line, in one row for each place."""
        numpy = load_numpy()
        pieces = numpy.ndarray(len(self._padded) - count, f"V{count}", self._padded, 0, (1,))
        found = pieces[begin + _BEFORE].view("u1").reshape(-1, count)
        return numpy.ascontiguousarray(found.T)

    def _time_ns(self) -> Any:
        seconds = self._decimal(self._close - 17, 10, self._close - 8 - self._starts)
        return seconds * 10**9 + self._decimal(self._close - 6, 6, 6) * 1000

    def _decimal(self, begin: Any, count: int, width: Any) -> Any:
        """Return the numbers in these `count` characters, an even number, of which the last `width` are digits."""
        numpy = load_numpy()
        digits = self._columns(begin, count) - numpy.uint8(48)
        digits = numpy.where(_counted(count)[::-1] < width, digits, 0)
        self.plain &= digits.max(0) < 10
        found = numpy.zeros(len(begin), "i8")
        for pair in digits[::2] * 10 + digits[1::2]:
            found = found * 100 + pair
        return found

    def _identifiers(self) -> Any:
        numpy = load_numpy()
        count = int(self._digits.max(initial=3))
        nibbles = hex_digits()[self._columns(self._hash - count, count)]
        nibbles = numpy.where(_counted(count)[::-1] < self._digits, nibbles, 0)
        self.plain &= nibbles.max(0) != NO_DIGIT
        found = numpy.zeros(len(self._starts), "u4")
        for nibble in nibbles:
            found = found << numpy.uint32(4) | nibble
        self.plain &= found <= numpy.where(self._extended, 0x1FFFFFFF, 0x7FF)  # else an error frame, or wrong
        return found

    def _fill_data(self, data: Any, length: Any) -> None:
        numpy = load_numpy()
        nibbles = hex_digits()[self._columns(self._hash + 1, 16)]
        nibbles = numpy.where(_counted(16) < length, nibbles, 0)
        self.plain &= nibbles.max(0) != NO_DIGIT
        data[:, :8] = (nibbles[::2] << 4 | nibbles[1::2]).T


def _counted(count: int) -> Any:
    """Return the numbers of the rows of `_columns`, to be compared with a number for each line."""
    return load_numpy().arange(count)[:, None]
