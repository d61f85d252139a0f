"""The store of numbered rows: in memory, in the file beyond it, and what is gone."""

from __future__ import annotations

import os

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import Frame, frames_to_array
from canwire.web.trace.store import history as module
from canwire.web.trace.store.history import History
from canwire.web.trace.store.merging import Merger
from canwire.web.trace.store.rows import EVERY_LINE, GAP, LATE, LOST, ROW_BYTES, mark_row, row_dtype, rows_of
from tests.effort import examples

pytestmark = pytest.mark.conforms("PG-04", "N-53")


def records(*stamps: int) -> numpy.ndarray:
    array = frames_to_array([Frame(stamp & 0x7FF) for stamp in stamps])
    array["time_ns"] = stamps
    return array


def stamps_of(history: History) -> list[int]:
    found: list[int] = history.read(0, history.total)["record"]["time_ns"].tolist()
    return found


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of 16 rows."""
    monkeypatch.setattr(module, "CHUNK", 16)


def test_a_row_has_the_size_that_the_page_counts_on() -> None:
    assert row_dtype().itemsize == ROW_BYTES == 88


@pytest.mark.finding("page B1")
@pytest.mark.usefixtures("small")
@examples(60)
@given(st.lists(st.integers(0, 70), max_size=12), st.integers(0, 400), st.integers(0, 400))
def test_every_row_is_kept_with_its_number_until_the_oldest_go(
    counts: list[int], begin: int, end: int
) -> None:
    """64 rows fit into memory, 160 into the file."""
    history = History(memory=64, most=160)
    for count in counts:
        first = history.total
        history.append(rows_of(records(*range(first, first + count)), 1))
    total = sum(counts)
    assert history.total == total
    assert history.first == max(0, (total + 15) // 16 * 16 - 160 if total else 0)
    expected = list(range(max(begin, history.first), min(end, total)))
    rows = history.read(begin, end)
    assert rows["number"].tolist() == rows["record"]["time_ns"].tolist() == expected
    some = numpy.arange(0, total, 7)
    assert history.pick(some)["number"].tolist() == [one for one in some if one >= history.first]
    blocks = [int(number) for block in history.blocks(0, total) for number in block["number"]]
    assert blocks == list(range(history.first, total))
    history.close()


@pytest.mark.usefixtures("small")
def test_a_full_disk_is_told_and_the_newest_rows_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError("No space left on device")

    monkeypatch.setattr(os, "pwrite", full)
    history = History(memory=32, most=160)
    history.append(rows_of(records(*range(100)), 1))
    assert history.trouble == "No space left on device"
    assert history.first == 80
    assert stamps_of(history) == list(range(80, 100))
    history.close()


def test_listeners_hear_of_every_write_until_they_leave() -> None:
    history = History()
    heard: list[int] = []

    def grown() -> None:
        heard.append(history.total)

    history.listen(grown)
    history.append(rows_of(records(1, 2), 0))
    history.unlisten(grown)
    history.append(rows_of(records(3), 0))
    assert heard == [2]


@pytest.mark.finding("page 3")
def test_lines_are_merged_by_their_stamps_though_queues_are_read_one_after_the_other() -> None:
    """What line 1 put in while line 0 was being read comes in the next sweep, in its place."""
    history = History()
    merger = Merger(history)
    merger.take(records(10, 30), 0)
    merger.take(records(20, 40, 60), 1)
    merger.release()
    assert history.total == 0
    merger.take(records(50, 70), 0)
    merger.release()
    assert stamps_of(history) == [10, 20, 30, 40, 50, 60]
    merger.release()
    assert stamps_of(history)[-1] == 70
    assert history.late == 0


def test_a_row_that_comes_too_late_is_flagged_and_counted() -> None:
    history = History()
    merger = Merger(history)
    for stamps in ((10, 50), (), (20,), ()):
        if stamps:
            merger.take(records(*stamps), 0)
        merger.release()
    assert stamps_of(history) == [10, 50, 20]
    assert history.read(0, 3)["flags"].tolist() == [0, 0, LATE]
    assert history.late == 1


def test_a_mark_comes_after_what_was_taken_before_it_and_says_what_is_missing() -> None:
    history = History()
    merger = Merger(history)
    merger.take(records(10, 30), 0)
    merger.mark(LOST, 0, 1234)
    for _ in range(2):
        merger.release()
    row = history.read(2, 3)[0]
    assert row["record"]["info"] == LOST
    assert int.from_bytes(row["record"]["data"][:8].tobytes(), "little") == 1234


def test_another_hub_begins_another_era_and_its_rows_are_not_late() -> None:
    history = History()
    merger = Merger(history)
    merger.take(records(1000), 0)
    merger.restart(7_000)
    merger.mark(GAP, EVERY_LINE, 5)
    merger.take(records(10), 0)
    for _ in range(2):
        merger.release()
    assert stamps_of(history) == [1000, 0, 10]
    assert history.late == 0
    assert [tuple(era) for era in history.eras] == [(0, 0), (1, 7_000)]


def test_a_marks_row_is_about_all_lines() -> None:
    assert mark_row(GAP, EVERY_LINE, 1, 0)["line"][0] == EVERY_LINE
