"""A trace's folder: files by number, a journal while one grows, everything read back in its order."""

from __future__ import annotations

import os
import random
from collections.abc import Iterator
from pathlib import Path

import pyarrow.parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st

import canwire
from canwire import BadLog, BadValue, Frame, Lab, LogEntry, LogWriter, convert_log, create_log, open_log
from canwire.logs.recording import files as recording_files
from canwire.logs.trace import writing
from canwire.logs.trace.files import files_of, is_journal, opened
from tests.effort import examples
from tests.logs.contents import entries, fresh, same, some

CAR = Path(__file__).parents[3] / "examples" / "car-candump.log"


@pytest.fixture
def small_files(monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of a hundred entries."""
    monkeypatch.setattr(writing, "ENTRIES", 100)


def read(folder: Path) -> list[LogEntry]:
    with open_log(folder) as log:
        found = list(log)
        assert log.faults == []
    return found


@pytest.mark.conforms("PF-06", "PF-09")
def test_a_log_goes_there_and_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writing, "ENTRIES", 5000)
    written = convert_log(CAR, f"{tmp_path}/trace/")
    assert (written.format, written.count, written.left_out) == ("trace", 12974, {})
    assert sorted(os.listdir(tmp_path / "trace")) == ["00001.parquet", "00002.parquet", "00003.parquet"]
    convert_log(tmp_path / "trace", tmp_path / "back.log")
    convert_log(CAR, tmp_path / "same.log")
    assert (tmp_path / "back.log").read_bytes() == (tmp_path / "same.log").read_bytes()


@pytest.mark.conforms("PF-10")
@examples(15, same_fixtures=True)
@given(log=entries(), shuffled=st.booleans(), flushed=st.integers(0, 30), seed=st.integers(0, 99))
def test_whatever_the_order_of_times(
    tmp_path: Path, log: list[LogEntry], shuffled: bool, flushed: int, seed: int
) -> None:
    """Equal times and a clock that runs backwards, in whole files and in a journal."""
    if shuffled:
        random.Random(seed).shuffle(log)
    folder = fresh(tmp_path / "log.trace")
    with create_log(folder) as writer:
        writer.write_many(log[:flushed])
        writer.flush()
        writer.rotate()
        writer.write_many(log[flushed:])
        writer.flush()
        assert same(read(folder), log) or not log
    assert same(read(folder), log) or not log
    assert not any(name.endswith(".journal") for name in os.listdir(folder))


def test_files_are_by_identifier_and_say_how_to_put_them_back(tmp_path: Path) -> None:
    with create_log(tmp_path / "log.trace") as writer:
        writer.write_many(some(200))
    table = pyarrow.parquet.read_table(tmp_path / "log.trace" / "00001.parquet")
    ids = [(row["extended"], row["id"]) for row in table.select(["extended", "id"]).to_pylist()]
    assert ids == sorted(ids)
    assert b'"order": "time_ns, row"' in table.schema.metadata[b"canwire"]


def test_one_of_its_files_is_a_log_too(tmp_path: Path, small_files: None) -> None:
    log = some(250)
    with create_log(tmp_path / "log.trace") as writer:
        writer.write_many(log)
    assert same(read(tmp_path / "log.trace" / "00002.parquet"), log[100:200])
    assert same(read(tmp_path / "log.trace"), log)


def test_what_was_flushed_is_read_while_it_grows(tmp_path: Path, small_files: None) -> None:
    log, folder = some(250), tmp_path / "log.trace"
    writer = create_log(folder)
    for at in range(0, 240, 40):
        writer.write_many(log[at : at + 40])
        writer.flush()
        assert same(read(folder), log[: at + 40])
        assert writer.count == at + 40
    assert {"00001.parquet", "00003.parquet.journal"} <= {*os.listdir(folder)}
    writer.close()
    assert sorted(os.listdir(folder)) == ["00001.parquet", "00002.parquet", "00003.parquet"]


@pytest.mark.conforms("PF-11")
def test_a_journal_beside_its_whole_file_is_left_out(tmp_path: Path) -> None:
    """What a process leaves that is killed when the file has its name and the journal is still there."""
    log, folder = some(50), tmp_path / "log.trace"
    writer = create_log(folder)
    writer.write_many(log)
    writer.flush()
    journal = (folder / "00001.parquet.journal").read_bytes()
    writer.close()
    (folder / "00001.parquet.journal").write_bytes(journal)
    (folder / "00002.parquet.journal").touch()
    assert same(read(folder), log)


def test_without_entries_it_is_a_trace_still(tmp_path: Path) -> None:
    create_log(tmp_path / "log.trace").close()
    assert os.listdir(tmp_path / "log.trace") == ["00001.parquet"]
    assert read(tmp_path / "log.trace") == []


@pytest.mark.parametrize("damage", ["cut", "foreign", "empty"])
def test_a_damaged_file_is_told_and_the_others_read(tmp_path: Path, small_files: None, damage: str) -> None:
    log, folder = some(300), tmp_path / "log.trace"
    with create_log(folder) as writer:
        writer.write_many(log)
    victim = folder / "00002.parquet"
    if damage == "foreign":
        pyarrow.parquet.write_table(pyarrow.table({"a": [1]}), victim)
    else:
        victim.write_bytes(victim.read_bytes()[: 2000 * (damage == "cut")])
    with open_log(folder) as opened:
        assert same(list(opened), log[:100] + log[200:])
        (fault,) = opened.faults
    assert fault.where == "00002.parquet"
    assert ("a table without time_ns" if damage == "foreign" else "no whole Parquet file") in fault.what


def test_a_folder_that_is_none_is_one_clear_error(tmp_path: Path) -> None:
    with pytest.raises(BadLog, match="a folder without Parquet files, so no trace"):
        open_log(tmp_path)
    with open_log(CAR, format="trace") as log, pytest.raises(BadLog, match="no folder, so no trace"):
        list(log)


def test_a_trace_overwrites_nothing(tmp_path: Path) -> None:
    convert_log(CAR, tmp_path / "log.trace")
    with pytest.raises(BadValue, match="not empty; give the trace a new one"):
        convert_log(CAR, tmp_path / "log.trace")
    with pytest.raises(BadValue, match="cannot be written to standard output"):
        create_log("-", format="trace")
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="file"):
        create_log(tmp_path / "file", format="trace")


@pytest.mark.conforms("PC-09")
@pytest.mark.parametrize("rotate", [{"rotate_bytes": 10_000}, {"rotate_s": 0.5}])
def test_a_recording_begins_files_by_size_and_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rotate: dict[str, float]
) -> None:
    monkeypatch.setattr(recording_files, "_LOOK_AT_S", 0.0)
    seconds = iter(number / 50 for number in range(10_000))
    monkeypatch.setattr(recording_files.time, "monotonic", lambda: next(seconds))
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        node, _ = bus.node("node"), bus.node("acknowledges")
        with canwire.record(bus, tmp_path / "log.trace", **rotate) as recorder:  # type: ignore[arg-type]
            for number in range(500):
                node.send(Frame(number, bytes(8)))
                lab.run_for(0.001)
        assert recorder.files == [str(tmp_path / "log.trace")]
    assert len(os.listdir(tmp_path / "log.trace")) >= 4
    assert [entry.frame.id for entry in read(tmp_path / "log.trace") if entry.frame] == list(range(500))


@pytest.fixture
def full_disk() -> Iterator[None]:
    """No file of this process may grow beyond 100,000 bytes."""
    resource = pytest.importorskip("resource", reason="limits of files are Linux'")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def read_after(writer: LogWriter, raised: pytest.ExceptionInfo[OSError]) -> None:
    """What the error and the writer say is what is read."""
    assert raised.value.filename == writer.path
    with open_log(writer.path) as opened:
        assert len(list(opened)) == writer.count >= 1000
        assert opened.faults == []
    assert not any(name.endswith(".new") for name in os.listdir(writer.path))


def test_a_disk_that_is_full_for_the_journal(tmp_path: Path, full_disk: None) -> None:
    writer, log = create_log(tmp_path / "log.trace"), some(4000)

    def fill() -> None:
        for at in range(0, len(log), 100):
            writer.write_many(log[at : at + 100])
            writer.flush()

    with pytest.raises(OSError, match="the file ends whole, with its first") as raised:
        fill()
    read_after(writer, raised)
    writer.close()  # packed it fits
    assert writer.count > 1000
    assert os.listdir(writer.path) == ["00001.parquet"]


def test_a_disk_that_is_full_for_a_whole_file(tmp_path: Path, full_disk: None) -> None:
    """It is not there at all; the others are, and it is tried once more at the end."""
    writer = create_log(tmp_path / "log.trace")
    writer.write_many(some(1000))
    writer.rotate()
    writer.write_many(
        LogEntry(number, "can0", Frame(0x100, random.randbytes(8), timestamp_ns=number))
        for number in range(20_000)
    )
    writer.rotate()
    with pytest.raises(OSError, match="the file ends whole, with its first 1000 entries") as raised:
        writer.rotate()
    read_after(writer, raised)
    with pytest.raises(OSError, match="too large"):
        writer.close()


def test_a_journal_that_becomes_a_file_while_it_is_looked_for(tmp_path: Path) -> None:
    log, folder = some(50), tmp_path / "log.trace"
    writer = create_log(folder)
    writer.write_many(log)
    writer.flush()
    (listed,) = files_of(str(folder))
    assert is_journal(listed)
    writer.close()
    file, found = opened(listed)
    file.close()
    assert found == folder / "00001.parquet"
