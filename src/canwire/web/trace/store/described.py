"""Selects rows by network descriptions: frames by message name, and frames by the value of a signal."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy

from canwire import BadFrame, LinFrame
from canwire.web.trace.store.kinds import EXTENDED, Mask, Test, identifiers, is_frame, is_lin, kind_of
from canwire.web.trace.store.lin import lin_message

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from canwire.web.database import Database

_COMPARE: dict[str, Callable[[NDArray[numpy.float64], float], Mask]] = {
    "=": operator.eq, "==": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le,
    ">": operator.gt, ">=": operator.ge,
}  # fmt: skip


class DescribedLines(NamedTuple):
    """Lines by their numbers in rows, and the descriptions of their frames."""

    database: Database
    lines: Sequence[int]


class Described:
    """The description of several lines, each by the files for its bus."""

    def __init__(self, groups: Sequence[DescribedLines]) -> None:
        self._groups = groups

    def named(self, like: str) -> Test | None:
        """Select frames whose message name contains this lower-case text; None if no name does."""
        tests = []
        for database, lines in self._groups:
            keys = [key for key, name in database.names.items() if like in name.lower()]
            if keys:
                tests.append(_of_keys(keys, lines))
        return _any(tests) if tests else None

    def compared(self, name: str, compare: str, text: str) -> Test:
        """Select frames whose signal compares so ("<") with a typed value; raises ValueError for an unknown signal."""
        tests = []
        for database, lines in self._groups:
            try:
                value = database.parsed(name, text)
            except ValueError:
                continue
            tests.append(_of_signal(database, lines, name, _COMPARE[compare], value))
        if not tests:
            raise ValueError(f"{name}: {text}")
        return _any(tests)


def signal_values(rows: numpy.ndarray, database: Database, name: str) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Return the places of the frames with the signal, and its physical values."""
    places, values = [numpy.zeros(0, numpy.intp)], [numpy.zeros(0)]
    can = numpy.flatnonzero(kind_of(rows) == 0)
    keys = rows["record"]["id"][can] | (rows["record"]["info"][can] & EXTENDED) << 8
    can = can[numpy.isin(keys, numpy.array(database.ids_with(name), numpy.uint32))]
    if len(can):
        for at, found in database.values_of(rows["record"][can], name):
            places.append(can[at])
            values.append(found.astype(float))
    for place in numpy.flatnonzero(is_lin(rows) & is_frame(rows)):
        number = lin_value(rows["record"][place].tobytes(), database, name)
        if number is not None:
            places.append(numpy.array([place]))
            values.append(numpy.array([number]))
    return numpy.concatenate(places), numpy.concatenate(values)


def lin_value(record: bytes, database: Database, name: str) -> float | None:
    """Return a signal's value in a LIN frame; None if the frame does not contain it."""
    try:
        frame = lin_message(record)
    except (ValueError, BadFrame):
        return None
    return database.number(frame, name) if isinstance(frame, LinFrame) else None


def _of_keys(keys: Sequence[str], lines: Sequence[int]) -> Test:
    """Select frames on these lines by "1A2", "000001A2" (29 bits) and "2A" (LIN)."""
    can = [int(key, 16) | (1 << 31 if len(key) == 8 else 0) for key in keys if len(key) > 2]
    lin = [int(key, 16) for key in keys if len(key) == 2]
    wanted, of_lin = numpy.array(can, numpy.uint32), numpy.array(lin, numpy.uint32)
    numbers = numpy.array(lines, numpy.uint16)

    def test(rows: numpy.ndarray) -> Mask:
        keys = rows["record"]["id"] | (rows["record"]["info"] & EXTENDED) << 8
        found = (kind_of(rows) == 0) & numpy.isin(keys, wanted)
        if lin:
            found |= is_lin(rows) & is_frame(rows) & numpy.isin(identifiers(rows), of_lin)
        return found & numpy.isin(rows["line"], numbers)

    return test


def _of_signal(
    database: Database,
    lines: Sequence[int],
    name: str,
    compare: Callable[[NDArray[numpy.float64], float], Mask],
    value: float,
) -> Test:
    numbers = numpy.array(lines, numpy.uint16)

    def test(rows: numpy.ndarray) -> Mask:
        passed = numpy.zeros(len(rows), bool)
        there = numpy.flatnonzero(numpy.isin(rows["line"], numbers))
        if len(there):
            places, values = signal_values(rows[there], database, name)
            passed[there[places]] = compare(values, value)
        return passed

    return test


def _any(tests: Sequence[Test]) -> Test:
    def test(rows: numpy.ndarray) -> Mask:
        passed = tests[0](rows)
        for one in tests[1:]:
            passed = passed | one(rows)
        return passed

    return test
