"""Recordings: of the lab, of shared lines, by size and time, with the disk full, and killed."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

import canwire
from canwire import (
    BadValue,
    BusEvent,
    ErrorState,
    Frame,
    Lab,
    LogEntry,
    LogMark,
    MarkKind,
    create_log,
    open_log,
)
from canwire.logs.recording import files as recording_files
from tests.hubs import LONG_S, Served, serving, stopped_meanwhile
from tests.logs.contents import some

FORMATS = ["log", "asc", "blf", "trc", "csv", "mf4", "parquet", "pcapng", "db", "trace"]


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving(tmp_path_factory.mktemp("hub"), time="real") as found:
        yield found


@pytest.mark.conforms("PF-10")
@pytest.mark.parametrize("suffix", FORMATS)
def test_a_bus_of_the_lab(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"drive.{suffix}"
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        engine, tester = bus.node("engine"), bus.node("tester")
        with canwire.record(bus, path) as recorder:
            for number in range(60):
                (engine, tester)[number % 2].send(Frame(0x100 + number, bytes((number,))))
                lab.run_for(0.001)
            assert recorder.count > 50
        lab.run_for(0.1)
    with open_log(path) as log:
        frames = [entry for entry in log if entry.frame]
        assert [entry.frame.id for entry in frames if entry.frame] == [0x100 + number for number in range(60)]
        assert {entry.channel for entry in frames} == {"can0"}
        assert not log.dated
    assert recorder.files == [str(path)]
    assert sorted(os.listdir(tmp_path)) == [path.name]


def test_what_goes_wrong_on_a_bus_is_recorded(tmp_path: Path) -> None:
    path = tmp_path / "drive.blf"
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        lonely = bus.node("lonely")
        with canwire.record(lonely, path):
            lonely.send(Frame(0x123))
            lab.run_for(0.01)
    with open_log(path) as log:
        contents = [entry.content for entry in log]
    events = [content for content in contents if isinstance(content, BusEvent)]
    assert {event.kind.name for event in events} == {"ERROR", "STATE"}
    marks = [content for content in contents if isinstance(content, LogMark)]
    assert [(mark.kind, mark.bit_rate, mark.text) for mark in marks] == [
        (MarkKind.CLOCK, 0, "lab"), (MarkKind.BIT_RATE, 500_000, "")]  # fmt: skip


@pytest.mark.finding("socketcan 1")
def test_a_line_that_is_stopped_before_the_recorder_hears_it_is_recorded(
    tmp_path: Path, served: Served
) -> None:
    with canwire.connect(served.address) as hub, stopped_meanwhile(hub):
        canwire.record("HW000001:0", tmp_path / "drive.log", hub=served.address).close()
    with open_log(tmp_path / "drive.log") as log:
        states = [entry.content.state for entry in log if isinstance(entry.content, BusEvent)]
    assert states == [ErrorState.STOPPED]


def test_lost_frames_are_counted_in_the_log(tmp_path: Path) -> None:
    path = tmp_path / "drive.pcapng"
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=1_000_000)
        sender, small = bus.node("sender"), bus.node("small", receive_queue=4)
        with canwire.record(small, path) as recorder:
            for number in range(40):
                sender.send(Frame(0x100 + number))
            lab.run_for(0.1)
        lost = small.lost
    assert recorder.lost == lost > 0
    with open_log(path) as log:
        marks = [entry.content for entry in log if isinstance(entry.content, LogMark)]
    assert sum(mark.count for mark in marks if mark.kind is MarkKind.LOST) == lost


def test_files_rotate_by_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording_files, "_LOOK_AT_S", 0.0)
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        node, _ = bus.node("node"), bus.node("acknowledges")
        with canwire.record(bus, tmp_path / "drive.log", rotate_bytes=10_000) as recorder:
            for number in range(1000):
                node.send(Frame(number, bytes(8)))
                lab.run_for(0.001)
    names = [Path(name).name for name in recorder.files]
    assert names[:2] == ["drive-0001.log", "drive-0002.log"]
    assert len(names) > 3
    found = []
    for name in recorder.files:
        with open_log(name) as log:
            found += [entry.frame.id for entry in log if entry.frame]
        assert os.path.getsize(name) < 20_000
    assert found == list(range(1000))


@pytest.mark.parametrize("wrong", [{"rotate_bytes": 10}, {"rotate_s": 0.0}, {"format": "nothing"}])
def test_impossible_wishes(tmp_path: Path, wrong: dict[str, object]) -> None:
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        with pytest.raises(BadValue):
            canwire.record(bus, tmp_path / "drive.log", **wrong)  # type: ignore[arg-type]
        with pytest.raises(BadValue, match="no line that can be recorded"):
            canwire.record(lab, tmp_path / "drive.log")  # type: ignore[arg-type]
    assert os.listdir(tmp_path) == []


RECORDS = """
import sys, time, canwire
folder, hub, *suffixes = sys.argv[1:]
recorders = [canwire.record("can0", f"{folder}/{suffix}/drive.{suffix}", hub=hub) for suffix in suffixes]
print("recording", flush=True)
while any(recorder.count < 50 for recorder in recorders):
    time.sleep(0.01)
time.sleep(1.0)  # what the promise allows
print("a second later", flush=True)
sys.stdin.read()
"""
KILLED_FORMATS = ["log", "blf", "mf4", "parquet", "db", "pcapng", "trace"]


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory, served: Served) -> Path:
    """What a process leaves that recorded 50 frames in each format, and was killed a second after the last came."""
    folder = tmp_path_factory.mktemp("killed")
    for suffix in KILLED_FORMATS:
        (folder / suffix).mkdir()
    process = subprocess.Popen(
        [sys.executable, "-c", RECORDS, str(folder), served.address, *KILLED_FORMATS],
        stdout=subprocess.PIPE, stdin=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    with process:
        try:
            assert process.stdout.readline() == "recording\n"
            send = ["send", "can0", "123#1122", "-n", "50", "--hub", served.address]
            subprocess.run(
                [sys.executable, "-m", "canwire", *send], check=True, timeout=LONG_S, capture_output=True
            )
            assert process.stdout.readline() == "a second later\n"
        finally:
            process.send_signal(signal.SIGKILL)
            process.wait(LONG_S)
    return folder


@pytest.mark.realtime
@pytest.mark.conforms("PF-11")
@pytest.mark.parametrize("suffix", KILLED_FORMATS)
def test_killed_all_that_is_older_than_a_second_is_there(killed: Path, suffix: str) -> None:
    folder = killed / suffix
    path = folder / f"drive.{suffix}"
    with open_log(path) as log:
        frames = [entry for entry in log if entry.frame]
        assert log.dated
    assert [(entry.frame.id, entry.frame.data) for entry in frames if entry.frame] == [
        (0x123, b"\x11\x22")
    ] * 50
    assert abs(frames[-1].timestamp_ns - time.time_ns()) < 600e9
    if suffix == "trace":
        assert os.listdir(path) == ["00001.parquet.journal"]
    if suffix in ("mf4", "parquet"):
        assert os.listdir(folder) == [path.name + ".journal"]
        canwire.convert_log(str(path) + ".journal", path)
        with open_log(path) as log:
            assert log.format == suffix
            assert len([entry for entry in log if entry.frame]) == 50


@pytest.fixture
def small_files() -> Iterator[None]:
    """No file of this process may grow beyond 100,000 bytes: a full disk's error at a place that is known."""
    resource = pytest.importorskip("resource", reason="limits of files are Linux'")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("suffix", ["log", "csv", "asc", "trc", "pcapng", "blf"])
def test_a_full_disk_is_said_and_the_file_ends_whole(tmp_path: Path, small_files: None, suffix: str) -> None:
    path = tmp_path / f"drive.{suffix}"
    log = [entry._replace(content=Frame(entry.content.id, random.randbytes(8), timestamp_ns=entry.timestamp_ns))
           for entry in some(20_000) if isinstance(entry.content, Frame)]  # fmt: skip
    writer = create_log(path)

    def fill() -> None:
        for at in range(0, len(log), 100):
            writer.write_many(log[at : at + 100])
            writer.flush()

    with pytest.raises(OSError, match="the file ends whole, with its first") as raised:
        fill()
    assert raised.value.filename == str(path)
    count = writer.count
    with suppress(OSError):  # a last line may fit, or not
        writer.close()
    with open_log(path) as opened:
        assert len(list(opened)) == count > 0
        assert opened.faults == []


KILLED = """
import os, sqlite3, sys
database = sqlite3.connect(sys.argv[1])
database.execute("pragma cache_size = 1")  # changes reach the file at once, and the journal what was there
database.execute("update entries set channel = 'changed'")
rows = [(k, "x" * 100) for k in range(5000)]
database.executemany("insert into entries(time_ns, channel, type) values(?, '', ?)", rows)
os._exit(0)
"""


@pytest.mark.conforms("PF-11")
def test_a_database_whose_writer_was_killed_while_it_committed(tmp_path: Path) -> None:
    path = tmp_path / "drive.db"
    entries = [LogEntry(k, "can0", Frame(k, timestamp_ns=k)) for k in range(1000)]
    with create_log(path) as log:
        log.write_many(entries)
    subprocess.run([sys.executable, "-c", KILLED, str(path)], check=True, timeout=LONG_S)
    assert Path(f"{path}-journal").stat().st_size
    before = path.read_bytes()
    with open_log(path) as log:
        assert [entry.channel for entry in log] == ["can0"] * 1000
        assert not log.faults
    assert path.read_bytes() == before


def test_a_bus_is_recorded_more_than_once(tmp_path: Path) -> None:
    """Each recorder is a node of its own there, which leaves with its name."""
    with canwire.Lab() as lab:
        bus = lab.can_bus("can0")
        sender, _ = bus.node("a"), bus.node("b")
        for name in ("first.log", "second.log"):
            with canwire.record(bus, tmp_path / name):
                lab.run_for(0.001)
                sender.send(canwire.Frame(0x123))
                lab.run_until_idle()
            assert (tmp_path / name).read_text().count("123#") == 1
        assert list(bus.nodes) == ["a", "b"]


def test_a_recording_ends_by_its_stamps_and_keeps_nothing_later(tmp_path: Path) -> None:
    with canwire.Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        node, _ = bus.node("a"), bus.node("b")
        with canwire.record(bus, tmp_path / "span.log") as recorder:
            recorder.end_after(0.5)
            for number in range(10):
                node.send(canwire.Frame(number))
                lab.run_for(0.1)
            assert recorder.wait(0)
        with canwire.open_log(tmp_path / "span.log") as log:
            assert [entry.frame.id for entry in log if entry.frame] == list(range(5))
