"""Finds and reads the words or cells of many lines with numpy.

A column that was read contains a number for each line, and a mask of the lines where the number is valid; other
numbers are arbitrary.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from canwire.values.record import load_numpy

NO_DIGIT = 0xFF
"""The value in `hex_digits` of a character that is not a hex digit."""
_ROOM = 64  # bytes behind the last line, to gather from


class Fields:
    """The fields of each line of a text, separated by blanks, or by commas if `separator` is a comma.

    `count` is the number of fields in each line; `clean` lines consist of printable ASCII, blanks and tabs.
    """

    def __init__(self, text: bytes, separator: int | None = None) -> None:
        numpy = load_numpy()
        self.text = text
        self._block = block = numpy.frombuffer(text + b"\n" * _ROOM, numpy.uint8)
        inside = block[: len(text)]
        ends = numpy.flatnonzero(inside == 10)
        if not text.endswith(b"\n"):
            ends = numpy.append(ends, len(text))
        self.line_begins = numpy.concatenate(([0], ends[:-1] + 1))
        self.line_ends = ends
        if separator is None:
            blank = block[: len(text) + 1] <= 32
            edges = numpy.flatnonzero(numpy.diff(blank, prepend=True))
            self._begins, self._ends = edges[::2], edges[1::2]
        else:
            edges = numpy.flatnonzero((inside == separator) | (inside == 10))
            self._ends = numpy.append(edges, len(text)) if not text.endswith(b"\n") else edges
            self._begins = numpy.concatenate(([0], self._ends[:-1] + 1))
            self._ends = self._ends - ((block[self._ends - 1] == 13) & (block[self._ends] == 10))
        self._first = numpy.searchsorted(self._begins, self.line_begins)
        self.count = numpy.diff(numpy.append(self._first, len(self._begins)))
        self._begins = numpy.append(self._begins, len(text))  # there is one at least
        self._ends = numpy.append(self._ends, len(text))
        self.clean = self._cleanness(inside)

    def __len__(self) -> int:
        return len(self.line_ends)

    def line(self, number: int) -> bytes:
        """One line, without its end."""
        return self.text[self.line_begins[number] : self.line_ends[number]]

    def at(self, column: Any, those: Any) -> Column:
        """Return this field (a number, or one for each line) of these lines; meaningless where a
        line has fewer fields."""
        numpy = load_numpy()
        there = numpy.minimum(self._first[those] + column, len(self._begins) - 1)
        return Column(self._block, self._begins[there], self._ends[there])

    def _cleanness(self, inside: Any) -> Any:
        numpy = load_numpy()
        dirty = numpy.flatnonzero(_dirt()[inside])
        clean = numpy.ones(len(self), bool)
        clean[numpy.searchsorted(self.line_ends, dirty)] = False
        return clean


class Column:
    """One field of every line: its beginning and end in the block."""

    def __init__(self, block: Any, begins: Any, ends: Any) -> None:
        self._block = block
        self.begins = begins
        self.size = ends - begins

    def character(self, place: int) -> Any:
        """Return the byte at this place of each field; negative places count from its end."""
        numpy = load_numpy()
        at = self.begins + (place if place >= 0 else self.size + place)
        return self._block[numpy.clip(at, 0, len(self._block) - 1)]

    def is_word(self, word: bytes) -> Any:
        """Whether each field is exactly this word."""
        found = self.size == len(word)
        for place, character in enumerate(word):
            found = found & (self.character(place) == character)
        return found

    def part(self, begin: Any, size: Any) -> Column:
        """The part of each field that begins at `begin` and has `size` characters."""
        return Column(self._block, self.begins + begin, self.begins + begin + size)

    def decimal(self, most: int) -> tuple[Any, Any]:
        """Read a whole number of 1 to `most` decimal digits; returns numbers and a mask of the valid ones."""
        return self._number(most, 10)

    def hexadecimal(self, most: int) -> tuple[Any, Any]:
        """Read a whole number of 1 to `most` hex digits; returns numbers and a mask of the valid ones."""
        return self._number(most, 16)

    def nanoseconds(self, digits: int) -> tuple[Any, Any]:
        """Read `123.456789` as a whole number in units of 10 to the minus `digits`; a number without a point is
        invalid."""
        numpy = load_numpy()
        point = numpy.full(len(self.begins), -1)
        for place in range(int(min(self.size.max(initial=0), 24)) - 1, 0, -1):
            point = numpy.where((self.character(place) == 46) & (place < self.size), place, point)
        behind = self.size - point - 1
        whole, good = self.part(0, point).decimal(12)
        rest, fine = self.part(point + 1, behind).decimal(digits)
        scale = numpy.int64(10) ** numpy.clip(digits - behind, 0, digits)
        return whole * 10**digits + rest * scale, good & fine & (point > 0)

    def bytes_in_hex(self, into: Any, length: Any) -> Any:
        """Read `length` pairs of adjacent hex digits in each line into rows of `into`; returns a mask of the valid
        lines."""
        numpy = load_numpy()
        good = numpy.ones(len(self.begins), bool)
        for place in range(int(length.max(initial=0))):
            there = length > place
            value, fine = self._pair(2 * place)
            into[:, place] = numpy.where(there & fine, value, 0)
            good &= fine | ~there
        return good

    def pair(self) -> tuple[Any, Any]:
        """Read exactly two hex digits; returns numbers and a mask of the valid ones."""
        value, good = self._pair(0)
        return value, good & (self.size == 2)

    def _pair(self, place: int) -> tuple[Any, Any]:
        high = hex_digits()[self.character(place)]
        low = hex_digits()[self.character(place + 1)]
        return high << 4 | low & 15, (high != NO_DIGIT) & (low != NO_DIGIT)

    def _number(self, most: int, base: int) -> tuple[Any, Any]:
        numpy = load_numpy()
        value = numpy.zeros(len(self.begins), numpy.int64)
        good = (self.size >= 1) & (self.size <= most)
        for place in range(int(min(self.size.max(initial=0), most))):
            digit = hex_digits()[self.character(place)]
            there = self.size > place
            good &= (digit < base) | ~there
            value = numpy.where(there, value * base + digit, value)
        return value, good


def fill_data(fields: Fields, those: Any, first: int, length: Any, into: Any) -> Any:
    """Read bytes that are words of two hex digits each, from the word `first` on; returns a mask of the valid lines."""
    numpy = load_numpy()
    good = fields.count[those] >= first + length
    for place in range(int(length.max(initial=0))):
        there = length > place
        value, fine = fields.at(first + place, those).pair()
        good &= fine | ~there
        into[:, place] = numpy.where(there & fine, value, 0)
    return good


@cache
def hex_digits() -> Any:
    """Return a table of the values of hex digits by character, with 0xFF for other characters."""
    numpy = load_numpy()
    table = numpy.full(256, NO_DIGIT, numpy.uint8)
    for characters in ("0123456789ABCDEF", "0123456789abcdef"):
        for value, character in enumerate(characters):
            table[ord(character)] = value
    return table


@cache
def _dirt() -> Any:
    """Return a table of the bytes that are neither printable ASCII nor a blank, a tab, or an end of line."""
    numpy = load_numpy()
    table = numpy.ones(256, bool)
    table[32:127] = False
    table[[9, 10, 13]] = False
    return table
