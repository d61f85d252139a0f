"""The table of one row for each frame: counts, distances, and when each byte changed."""

from __future__ import annotations

import itertools
from collections import defaultdict

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import Frame, frames_to_array
from canwire.web.trace.store import identifiers as module
from canwire.web.trace.store.identifiers import Identifiers, Page
from canwire.web.trace.store.rows import LOST, mark_row, rows_of
from tests.effort import examples

pytestmark = pytest.mark.conforms("PG-03")

NONE = numpy.zeros(0)


def rows(*told: tuple[int, int, int], line: int = 0) -> numpy.ndarray:
    """Stamp in ms, identifier, first byte."""
    array = frames_to_array([Frame(identifier, bytes([octet, 7])) for _, identifier, octet in told])
    array["time_ns"] = [stamp * 1_000_000 for stamp, _, _ in told]
    return rows_of(array, line)


def whole(table: Identifiers, lines: tuple[int, ...] = (0, 1)) -> Page:
    return table.page(lines, None, NONE, 0, 1000)


@pytest.mark.finding("page B2")
@examples(60)
@given(
    st.lists(
        st.tuples(st.integers(1, 40), st.sampled_from([0x100, 0x200, 0x300]), st.integers(0, 2)), max_size=40
    ),
    st.lists(st.integers(0, 40), max_size=6),
)
def test_it_says_what_one_row_after_the_other_says(told: list[tuple[int, int, int]], cuts: list[int]) -> None:
    """`told` begins with the distance to the row before."""
    stamp = 0
    listed = []
    for apart, identifier, octet in told:
        stamp += apart
        listed.append((stamp, identifier, octet))
    table = Identifiers()
    edges = sorted({0, len(listed), *(min(cut, len(listed)) for cut in cuts)})
    for begin, end in itertools.pairwise(edges):
        table.add(rows(*listed[begin:end]))
    by_id = defaultdict(list)
    for one in listed:
        by_id[one[1]].append(one)
    page = whole(table)
    assert page.rows["record"]["id"].tolist() == sorted(by_id)
    for row, extra in zip(page.rows, page.extra, strict=True):
        came = by_id[int(row["record"]["id"])]
        apart_ns = [(b[0] - a[0]) * 1e6 for a, b in itertools.pairwise(came)]
        changes = [b[0] * 1_000_000 for a, b in itertools.pairwise(came) if a[2] != b[2]]
        assert extra["count"] == len(came)
        assert row["record"]["time_ns"] == came[-1][0] * 1_000_000
        assert extra["cycle"] == (apart_ns[-1] if apart_ns else 0)
        assert (extra["least"], extra["most"]) == ((min(apart_ns), max(apart_ns)) if apart_ns else (0, 0))
        assert extra["changed"][0] == max(changes, default=0)
        assert extra["changed"][1] == 0


def test_lines_are_apart_and_marks_are_no_frames() -> None:
    table = Identifiers()
    table.add(rows((1, 0x100, 0)))
    table.add(rows((2, 0x100, 0), line=1))
    table.add(mark_row(LOST, 0, 1, 0))
    assert whole(table).rows["line"].tolist() == [0, 1]
    assert whole(table, (1,)).length == 1


def test_what_came_before_it_was_cleared_is_not_counted() -> None:
    table = Identifiers()
    table.add(rows((1, 0x100, 0), (2, 0x100, 0), (3, 0x200, 0)))
    before = table.counts()
    table.add(rows((4, 0x100, 0), (5, 0x300, 0)))
    page = table.page((0,), None, before, 0, 10)
    assert page.rows["record"]["id"].tolist() == [0x100, 0x300]
    assert page.extra["count"].tolist() == [1, 1]


@pytest.mark.finding("page 4")
def test_a_snapshot_keeps_what_it_has() -> None:
    table = Identifiers()
    table.add(rows((1, 0x100, 0)))
    copied = table.copy()
    table.add(rows((2, 0x100, 0), (3, 0x200, 0)))
    assert whole(copied).extra["count"].tolist() == [1]


@pytest.mark.finding("page 15")
def test_frames_beyond_its_room_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST", 2)
    table = Identifiers()
    table.add(rows((1, 1, 0), (2, 2, 0), (3, 3, 0), (4, 3, 0)))
    assert (whole(table).length, table.left_out) == (2, 2)
