"""What is written in a format is read from it, whatever it is; what a format cannot hold is counted."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, assume, given, settings

from canwire import (
    BusEvent,
    Frame,
    LinFrame,
    LogBatch,
    LogEntry,
    LogKind,
    LogMark,
    create_log,
    log_formats,
    open_log,
)
from tests.logs.contents import START_NS, entries, frames, fresh, same, some

FOREIGN = ("gvret", "python-can-csv", "python-can-db")  # they say less of a frame: test_foreign_tables.py
WRITTEN = [row.name for row in log_formats() if row.writes and row.name not in FOREIGN]
WHOLE = [
    "csv",
    "pcapng",
    "sqlite",
    "parquet",
    "asc",
    "blf",
    "journal",
    "trace",
]  # they hold everything, to the nanosecond
SUFFIXES = {row.name: row.suffixes[0] for row in log_formats()}
quick = settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def written(path: Path, log: list[LogEntry], form: str) -> dict[str, int]:
    fresh(path)
    with create_log(path, format=form) as writer:
        writer.write_many(log)
    return writer.left_out


def read(path: Path) -> list[LogEntry]:
    with open_log(path) as log:
        found = list(log)
        assert log.faults == []
        assert [entry for batch in log.batches() for entry in batch] == found
        assert log.dated
    return found


@pytest.mark.conforms("PF-10")
@pytest.mark.parametrize("form", WHOLE)
@quick
@given(log=entries())
def test_everything_comes_back(tmp_path: Path, form: str, log: list[LogEntry]) -> None:
    path = tmp_path / f"log{SUFFIXES[form]}"
    assert set(written(path, log, form)) == set()
    assert same(read(path), log)


@pytest.mark.conforms("PF-01", "PF-02", "PF-03", "PF-04", "PF-05", "PF-06", "PF-07")
@pytest.mark.parametrize("form", ["candump", "trc", "mf4"])
@quick
@given(log=entries(frames(), step_ns=1000))
def test_frames_come_back_to_the_microsecond(tmp_path: Path, form: str, log: list[LogEntry]) -> None:
    path = tmp_path / f"log{SUFFIXES[form]}"
    written(path, log, form)
    names = {entry.channel for entry in log}
    found = read(path)
    if form != "candump":  # numbers by order of appearance
        order = list(dict.fromkeys(entry.channel for entry in log))
        log = [entry._replace(channel=f"can{order.index(entry.channel)}") for entry in log]
    assert same(found, log)
    assert names <= {"can0", "can1"}


@pytest.mark.conforms("PF-09")
@pytest.mark.parametrize("form", WRITTEN)
@quick
@given(log=entries())
def test_what_is_left_out_is_counted(tmp_path: Path, form: str, log: list[LogEntry]) -> None:
    """As many entries are read as the writer says that it has written."""
    path = fresh(tmp_path / f"log{SUFFIXES[form]}")
    with create_log(path, format=form) as writer:
        writer.write_many(log)
    assume(
        path.stat().st_size
    )  # a text of which everything was left out is empty, and an empty file is no log
    with open_log(path) as opened:
        found = list(opened)
        assert opened.faults == []
    assert len(found) == writer.count
    assert len(log) - len(found) <= sum(writer.left_out.values())
    wanted = [entry.content for entry in log if isinstance(entry.content, Frame)]
    assert [entry.content for entry in found if isinstance(entry.content, Frame)] == wanted


@pytest.mark.parametrize("form", WRITTEN)
def test_times_from_zero_stay_so(tmp_path: Path, form: str) -> None:
    path = tmp_path / f"log{SUFFIXES[form]}"
    with create_log(path, dated=False, format=form) as writer:
        writer.write(LogEntry(5_000_000, "can0", Frame(0x123, b"\x11", timestamp_ns=5_000_000), "R"))
    with open_log(path) as log:
        assert [(entry.timestamp_ns, entry.channel) for entry in log] == [(5_000_000, "can0")]
        assert not log.dated
        assert log.start_ns is None


@pytest.mark.parametrize("form", ["csv", "blf", "asc", "parquet", "sqlite", "journal", "pcapng", "trace"])
def test_kinds_of_entries_have_their_kinds_in_batches(tmp_path: Path, form: str) -> None:
    from canwire import EventKind, LinEvent, LinEventKind, MarkKind

    contents = [Frame(1), BusEvent(EventKind.ERROR), LinFrame(2, b"\x01"), LinEvent(LinEventKind.SLEEP),
                LogMark(MarkKind.LOST, count=7)]  # fmt: skip
    log = [LogEntry(START_NS, "x0", content, None) for content in contents]
    path = tmp_path / f"log{SUFFIXES[form]}"
    with create_log(path, format=form) as writer:
        writer.write_many(log)
    with open_log(path) as opened:
        batches = list(opened.batches())
    kinds = [kind for batch in batches for kind in batch.records["kind"].tolist()]
    assert kinds == list(map(int, LogKind))
    assert sum(len(batch.frames) for batch in batches) == 1


@pytest.mark.parametrize("form", WRITTEN)
def test_batches_of_another_log_keep_their_channels(tmp_path: Path, form: str) -> None:
    """Indices of channels are each log's own."""
    one, two = some(8), [entry._replace(channel="can1") for entry in some(4)]
    path = tmp_path / f"log{SUFFIXES[form]}"
    with create_log(path, format=form) as writer:
        writer.write_many(two)
        first = writer.channels
        from canwire.logs.batch import batch_of

        writer.write_batch(batch_of(one, []))
        assert (first, writer.channels) == (["can1"], ["can1", "can0"])
    with open_log(path) as log:
        order = [entry.channel for entry in sorted(log, key=lambda entry: entry.timestamp_ns)]
    assert len(order) == 12
    assert len(set(order)) == 2


def test_a_batch_shows_itself() -> None:
    from canwire.logs.batch import batch_of

    assert repr(batch_of(some(3), [])) == "<LogBatch of 3 entries, channels can0, can1>"
    assert isinstance(batch_of(some(3), []), LogBatch)
