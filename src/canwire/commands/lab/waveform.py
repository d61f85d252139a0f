"""The level on a bus drawn with characters: recessive above, dominant below, two columns a bit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

_COLUMNS = 2  # an edge, or its place, and the level


class _Strokes(NamedTuple):
    """What to draw with: (upper, lower) for a falling edge, a rising edge, no edge at a level."""

    recessive: tuple[str, str]
    dominant: tuple[str, str]
    falling: tuple[str, str]
    rising: tuple[str, str]


_FANCY = _Strokes(("─", " "), (" ", "─"), ("┐", "└"), ("┌", "┘"))
_PLAIN = _Strokes(("_", " "), (" ", "_"), (" ", "|"), (" ", "|"))


def draw(
    levels: Sequence[int],
    stuffed: Sequence[int],
    names: Sequence[tuple[int, str]],
    width: int,
    *,
    fancy: bool,
) -> list[str]:
    """Lines of at most `width` columns: names of fields, upper line, lower line, `s` under stuff bits.

    `levels` are 0 or 1, `stuffed` marks stuff bits, `names` are (first bit, name) in order. `fancy` draws
    with box characters, else with ASCII. The bus is recessive before the first bit.
    """
    strokes = _FANCY if fancy else _PLAIN
    bits_a_row = max(1, width // _COLUMNS)
    lines = []
    for start in range(0, len(levels), bits_a_row):
        places = range(start, min(start + bits_a_row, len(levels)))
        upper = lower = ""
        for k in places:
            up, low = _bit(strokes, levels[k - 1] if k else 1, levels[k])
            upper, lower = upper + up, lower + low
        marks = "".join(" s" if stuffed[k] else "  " for k in places)
        here = [((first - start) * _COLUMNS + 1, name) for first, name in names if first in places]
        rows = [_labels(here, width), upper, lower, marks]
        lines += [row.rstrip() for row in rows if row.strip()]
        lines.append("")
    return lines[:-1]


def _bit(strokes: _Strokes, before: int, level: int) -> tuple[str, str]:
    """Upper and lower columns of one bit: its left edge and its level."""
    flat = strokes.recessive if level else strokes.dominant
    edge = flat if before == level else strokes.rising if level else strokes.falling
    return edge[0] + flat[0], edge[1] + flat[1]


def _labels(names: Sequence[tuple[int, str]], width: int) -> str:
    """Names over their columns; a name that would run into the next one is left out."""
    row = ""
    for k, (column, name) in enumerate(names):
        end = names[k + 1][0] if k + 1 < len(names) else width
        if len(row) <= column and column + len(name) < end + (end == width):
            row = row.ljust(column) + name
    return row
