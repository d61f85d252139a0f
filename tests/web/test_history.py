"""The ring of rows that every viewer reads at its own pace."""

from __future__ import annotations

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import Frame, frames_to_array
from canwire.web.trace.history import GAP, ROW_BYTES, History, row_dtype
from tests.effort import examples

pytestmark = pytest.mark.conforms("PG-04")


def records(first: int, count: int) -> numpy.ndarray:
    return frames_to_array([Frame(number & 0x7FF) for number in range(first, first + count)])


def test_a_row_has_the_size_that_the_page_counts_on() -> None:
    assert row_dtype().itemsize == ROW_BYTES == 88


def test_rows_come_in_order_with_their_numbers_and_lines() -> None:
    history = History(16)
    history.append(records(0, 3), 1)
    history.append(records(3, 2), 2)
    rows, skipped, after = history.since(0, 100)
    assert rows["record"]["id"].tolist() == rows["number"].tolist() == [0, 1, 2, 3, 4]
    assert rows["line"].tolist() == [1, 1, 1, 2, 2]
    assert (skipped, after) == (0, 5)


def test_rows_of_other_lines_are_left_out_and_not_counted_as_skipped() -> None:
    history = History(16)
    history.append(records(0, 3), 1)
    history.append(records(3, 2), 2)
    rows, skipped, after = history.since(0, 100, [2])
    assert rows["number"].tolist() == [3, 4]
    assert (skipped, after) == (0, 5)


@examples(100)
@given(st.lists(st.integers(0, 40), max_size=12), st.integers(1, 20), st.integers(1, 25))
def test_every_row_is_read_or_counted_as_skipped(batches: list[int], capacity: int, limit: int) -> None:
    history = History(capacity)
    cursor, seen, missed = 0, [], 0
    for count in batches:
        history.append(records(history.total, count), 0)
        rows, skipped, cursor = history.since(cursor, limit)
        seen += rows["number"].tolist()
        missed += skipped
    while cursor < history.total:
        rows, skipped, cursor = history.since(cursor, limit)
        seen += rows["number"].tolist()
        missed += skipped
    assert len(seen) + missed == history.total == sum(batches)
    assert seen == sorted(set(seen))


def test_a_mark_says_what_is_missing() -> None:
    history = History(4)
    history.mark(GAP, 7, 1234)
    (row,) = history.since(0, 1).rows
    assert row["record"]["info"] == GAP
    assert int.from_bytes(row["record"]["data"][:8].tobytes(), "little") == 1234
    assert row["line"] == 7


def test_listeners_hear_of_every_write_until_they_leave() -> None:
    history = History(4)
    heard: list[int] = []

    def grown() -> None:
        heard.append(history.total)

    history.listen(grown)
    history.append(records(0, 2), 0)
    history.unlisten(grown)
    history.append(records(2, 2), 0)
    assert heard == [2]
