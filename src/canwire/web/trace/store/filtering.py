"""Selects rows by filters, colour rules and searches, which use one language, for many rows at a time.

    100-1FF, !123, EngineData & Speed > 50, error, tx & can1, data: DE ?? BE

Parts separated by commas are alternatives, `!` before a part excludes matching rows, and `&` combines conditions.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy

from canwire.web.trace.store.kinds import (
    EXTENDED,
    FD,
    REMOTE,
    Mask,
    Test,
    identifiers,
    is_error,
    is_frame,
    is_lin,
    is_sent,
    kind_of,
    lengths,
)

if TYPE_CHECKING:
    from canwire.web.trace.store.described import Described

_RANGE = re.compile(r"(?:0x)?([0-9a-f]{1,8})(?:\s*-\s*(?:0x)?([0-9a-f]{1,8}))?", re.I)
_SIGNAL = re.compile(r"([A-Za-z_]\w*)\s*(==|!=|<=|>=|=|<|>)\s*(-?[\w.]+)")


class BadFilter(ValueError):
    """Raised for an invalid part of a filter."""


def _can_frame_with(bit: int, wanted: bool) -> Test:
    return lambda rows: (kind_of(rows) == 0) & ((rows["record"]["info"] & bit != 0) == wanted)


_WORDS: dict[str, Test] = {
    "error": is_error,
    "event": lambda rows: ~is_frame(rows),
    "frame": is_frame,
    "lin": is_lin,
    "can": lambda rows: ~is_lin(rows),
    "rtr": _can_frame_with(REMOTE, True),
    "fd": _can_frame_with(FD, True),
    "ext": _can_frame_with(EXTENDED, True),
    "std": _can_frame_with(EXTENDED, False),
    "tx": is_sent,
    "rx": lambda rows: is_frame(rows) & ~is_sent(rows),
}


class Language:
    """Compiles filters. `lines` are the numbers of lines by address and by bus, in lower case."""

    def __init__(self, described: Described, lines: Mapping[str, Sequence[int]]) -> None:
        self._described = described
        self._lines = lines

    def compile(self, text: str) -> Test | None:
        """Return a test of rows, None for an empty text; raises BadFilter with the invalid part."""
        wanted: list[Test] = []
        refused: list[Test] = []
        for part in filter(None, (one.strip() for one in re.split(r"[,;]", text))):
            if part.startswith("!") and "&" not in part:
                refused.append(self._term(part[1:].strip()))
            else:
                wanted.append(_all([self._factor(one.strip()) for one in part.split("&")]))
        if not wanted and not refused:
            return None

        def test(rows: numpy.ndarray) -> Mask:
            passed = numpy.full(len(rows), not wanted)
            for one in wanted:
                passed |= one(rows)
            for one in refused:
                passed &= ~one(rows)
            return passed

        return test

    def search(self, text: str) -> Test:
        """Select rows with this text in their identifier, name or data, or rows that match it as a filter word."""
        like = text.replace(" ", "").lower()
        if text.strip().lower() in _WORDS:
            return _WORDS[text.strip().lower()]
        data = data_pattern(like) if re.fullmatch(r"(?:[0-9a-f]{2}|\?\?)+", like) else None
        named = self._described.named(like)

        def test(rows: numpy.ndarray) -> Mask:
            found = is_frame(rows)
            shown = identifiers(rows)
            keys = shown | (rows["record"]["info"] & EXTENDED).astype(numpy.uint32) << 8
            there = [int(one) for one in numpy.unique(keys[found])]
            fits = [one for one in there if like in _id_text(one)]
            passed = numpy.isin(keys, numpy.array(fits, numpy.uint32))
            for one in filter(None, (named, data)):
                passed |= one(rows)
            return found & passed

        return test

    def _factor(self, text: str) -> Test:
        if not text.startswith("!"):
            return self._term(text)
        test = self._term(text[1:].strip())
        return lambda rows: ~test(rows)

    def _term(self, text: str) -> Test:
        name, colon, rest = text.partition(":")
        prefix, rest = name.strip().lower(), rest.strip()
        if colon and prefix in ("id", "name", "data", "bus"):
            return {"id": self._id, "name": self._name, "data": _data, "bus": self._line}[prefix](rest)
        if text.lower() in _WORDS:
            return _WORDS[text.lower()]
        if text.lower() in self._lines:
            return self._line(text)
        if _RANGE.fullmatch(text):
            return self._id(text)
        if signal := _SIGNAL.fullmatch(text):
            return self._signal(*signal.groups())
        return self._name(text)

    def _id(self, text: str) -> Test:
        found = _RANGE.fullmatch(text)
        if found is None:
            raise BadFilter(text)
        first, last = int(found[1], 16), int(found[2] or found[1], 16)
        if first > last:
            raise BadFilter(text)
        extended = EXTENDED if len(found[1]) == 8 and not found[2] else 0

        def test(rows: numpy.ndarray) -> Mask:
            shown = identifiers(rows)
            passed = is_frame(rows) & (shown >= first) & (shown <= last)
            return passed & (rows["record"]["info"] & extended != 0) if extended else passed

        return test

    def _name(self, text: str) -> Test:
        test = self._described.named(text.lower()) if text else None
        if test is None:
            raise BadFilter(text)
        return test

    def _line(self, text: str) -> Test:
        if text.lower() not in self._lines:
            raise BadFilter(text)
        wanted = numpy.array(self._lines[text.lower()], numpy.uint16)
        return lambda rows: numpy.isin(rows["line"], wanted)

    def _signal(self, name: str, compare: str, value: str) -> Test:
        try:
            return self._described.compared(name, compare, value)
        except ValueError:
            raise BadFilter(f"{name} {compare} {value}") from None


def directed(test: Test | None, *, sent: bool) -> Test:
    """Select rows that pass the test and were sent (or received); rows that are no frames need only pass the test."""
    direction: Test = lambda rows: ~is_frame(rows) | (is_sent(rows) == sent)  # noqa: E731
    return direction if test is None else _all([test, direction])


def _id_text(key: int) -> str:
    return f"{key & 0x1FFFFFFF:08x}" if key >> 31 else f"{key:03x}"


def _all(tests: list[Test]) -> Test:
    if len(tests) == 1:
        return tests[0]

    def test(rows: numpy.ndarray) -> Mask:
        passed = numpy.ones(len(rows), bool)
        for one in tests:
            passed &= one(rows)
        return passed

    return test


def _data(text: str) -> Test:
    like = text.replace(" ", "").lower()
    if not re.fullmatch(r"(?:[0-9a-f]{2}|\?\?){1,64}", like):
        raise BadFilter(f"data: {text}")
    return data_pattern(like)


def data_pattern(like: str) -> Test:
    """Select frames whose data contain these bytes at any place; "??" matches any byte."""
    octets = [
        None if "?" in like[at : at + 2] else int(like[at : at + 2], 16) for at in range(0, len(like), 2)
    ]

    def test(rows: numpy.ndarray) -> Mask:
        passed = numpy.zeros(len(rows), bool)
        if not len(rows):
            return passed
        room = lengths(rows) - len(octets)
        data = rows["record"]["data"]
        for start in range(int(room.max()) + 1):
            fits = room >= start
            for place, octet in enumerate(octets):
                if octet is not None:
                    fits &= data[:, start + place] == octet
            passed |= fits
        return passed

    return test
