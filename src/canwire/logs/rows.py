"""Joins blocks of different sizes in order; numpy lays out each size in rows of bytes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from canwire.values.record import load_numpy


def in_order(records: Any, kinds: Any, sizes: Mapping[int, int], make: Callable[[Any, int], Any]) -> bytes:
    """Return one block for each record: `kinds` are the blocks' kinds (small numbers), `sizes` the size of each kind.

    `make(records, kind)` lays out blocks of one kind as rows.
    """
    numpy = load_numpy()
    every = numpy.zeros(max(sizes) + 1, "i8")
    every[list(sizes)] = list(sizes.values())
    ends = numpy.cumsum(every[kinds])
    begins = ends - every[kinds]
    found = numpy.zeros(int(ends[-1]) if len(ends) else 0, "u1")
    for kind, size in sizes.items():
        those = kinds == kind
        if those.all():
            return bytes(make(records, kind).tobytes())
        if those.any():
            found[begins[those][:, None] + numpy.arange(size)] = make(records[those], kind)
    return bytes(found.tobytes())
