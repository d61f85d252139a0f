"""A signal's values over time, from the rows of a history: reduced to few points, but with every peak."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy

from canwire.web.trace.store.described import signal_values
from canwire.web.trace.store.kinds import EXTENDED, identifiers, is_frame, is_lin

if TYPE_CHECKING:
    from canwire.web.database import Database
    from canwire.web.trace.store.history import History

MOST_PLOTTED = 1_000_000  # rows that are looked at: the newest
MOST_POINTS = 8000


class Wanted(NamedTuple):
    """A signal of a frame on a line; the line is given by its number in rows."""

    line: int
    id: int
    extended: bool
    signal: str


def curve(
    history: History, database: Database, wanted: Wanted, begin: int, end: int
) -> tuple[list[float], list[float]]:
    """Return seconds and physical values in the rows between two numbers; of many points only the peaks."""
    times, values = [numpy.zeros(0)], [numpy.zeros(0)]
    for rows in history.blocks(begin, end):
        fits = is_frame(rows) & (rows["line"] == wanted.line) & (identifiers(rows) == wanted.id)
        fits &= ((rows["record"]["info"] & EXTENDED != 0) & ~is_lin(rows)) == wanted.extended
        if fits.any():
            places, some = signal_values(rows[fits], database, wanted.signal)
            times.append(rows["record"]["time_ns"][fits][places] / 1e9)
            values.append(some)
    return thinned(numpy.concatenate(times), numpy.concatenate(values))


def thinned(times: numpy.ndarray, values: numpy.ndarray) -> tuple[list[float], list[float]]:
    """Return at most MOST_POINTS points: the smallest and the largest value of each part."""
    if len(times) > MOST_POINTS:
        parts = MOST_POINTS // 2
        size = -(-len(times) // parts)
        whole = len(times) // size * size
        shaped = values[:whole].reshape(-1, size)
        begins = numpy.arange(0, whole, size)
        kept = numpy.r_[begins + shaped.argmin(1), begins + shaped.argmax(1), numpy.arange(whole, len(times))]
        kept = numpy.unique(kept)
        times, values = times[kept], values[kept]
    return times.tolist(), values.tolist()
