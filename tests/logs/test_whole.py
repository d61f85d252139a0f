"""What was at a log's name stays until another log is whole: after mistakes, bad input, a full disk and Ctrl-C."""

from __future__ import annotations

import os
import random
import signal
import sqlite3
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import (
    BadLog,
    BadValue,
    ExtraMissing,
    Frame,
    LogBatch,
    LogEntry,
    LogWriter,
    convert_log,
    create_log,
    log_formats,
    open_log,
)
from canwire.commands import main

OLD = b"a day of driving, of which there is no copy\n" * 100
FORMATS = [row.name for row in log_formats() if row.writes and row.name != "trace"]
SUFFIXES = {row.name: row.suffixes[0] for row in log_formats()}


@pytest.fixture(params=FORMATS)
def target(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A file of each format's name, in a folder of its own, with something in it."""
    if request.param == "mf4":
        pytest.importorskip("asammdf")
    elif request.param == "parquet":
        pytest.importorskip("pyarrow")
    (tmp_path / "out").mkdir()
    path = tmp_path / "out" / f"drive{SUFFIXES[request.param]}"
    path.write_bytes(OLD)
    return path


@pytest.fixture(scope="module")
def long(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log of 3 batches at least, that cannot be packed well; nobody writes it."""
    rng = random.Random(1)
    path = tmp_path_factory.mktemp("long") / "long.log"
    path.write_text(
        "".join(f"({k}.000000) can0 {k & 0x7FF:03X}#{rng.randbytes(8).hex()}\n" for k in range(90_000))
    )
    return path


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log of a hundred frames; nobody writes it."""
    path = tmp_path_factory.mktemp("short") / "short.log"
    path.write_text("".join(f"({k}.000000) can0 {k:03X}#0102\n" for k in range(100)))
    return path


@pytest.fixture
def small_files() -> Iterator[None]:
    """No file of this process may grow beyond 100,000 bytes: a full disk's error at a place that is known."""
    resource = pytest.importorskip("resource", reason="limits of files are Linux'")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def untouched(path: Path) -> bool:
    """It is as it was, and nothing else is there."""
    return path.read_bytes() == OLD and os.listdir(path.parent) == [path.name]


def interrupt(batch: LogBatch) -> LogBatch:
    """Ctrl-C, while a batch is chosen from."""
    signal.raise_signal(signal.SIGINT)
    return batch


class _Once:
    """The first batch passes, Ctrl-C comes with the second."""

    def __init__(self) -> None:
        self.passed = 0

    def __call__(self, batch: LogBatch) -> LogBatch:
        self.passed += 1
        return batch if self.passed == 1 else interrupt(batch)


def test_a_converted_log_takes_the_place_of_what_was_there(target: Path, short: Path) -> None:
    target.chmod(0o640)
    convert_log(short, target)
    assert os.listdir(target.parent) == [target.name]
    assert target.stat().st_mode & 0o777 == 0o640
    with open_log(target) as log:
        assert sum(1 for entry in log if entry.frame) == 100


@pytest.mark.finding("faults-2 8")
def test_a_mistake_in_the_arguments_leaves_what_was_there(target: Path, short: Path) -> None:
    wrong: Any = 7
    for options in ({"format": "nonsense"}, {"format": "busmaster"}):
        with pytest.raises(BadValue):
            convert_log(short, target, **options)  # type: ignore[arg-type]
    with pytest.raises(TypeError):
        convert_log(short, target, only=wrong)
    for words in ("--filter 9999999999:1", "--map can0", "--to nonsense", "--from nonsense"):
        assert main(["convert", str(short), str(target), *words.split()]) == 2
    assert untouched(target)


def test_an_input_that_cannot_be_read_leaves_what_was_there(target: Path, tmp_path: Path) -> None:
    (tmp_path / "none").write_bytes(b"no log at all\n")
    (tmp_path / "empty").write_bytes(b"")
    for name in ("none", "empty"):
        with pytest.raises(BadLog):
            convert_log(tmp_path / name, target)
    for name in ("missing", "."):
        with pytest.raises((OSError, BadLog)):
            convert_log(tmp_path / name, target)
    assert untouched(target)


def test_a_log_onto_itself_is_refused(long: Path) -> None:
    before = long.read_bytes()
    with pytest.raises(BadValue, match="the same file twice"):
        convert_log(long, long, format="csv")
    assert long.read_bytes() == before


def test_an_input_that_fails_halfway_leaves_what_was_there(
    target: Path, long: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    batches = canwire.Log.batches

    def failing(self: canwire.Log) -> Iterator[LogBatch]:
        yield next(batches(self))
        raise OSError(5, "Input/output error", self.path)

    monkeypatch.setattr(canwire.Log, "batches", failing)
    with pytest.raises(OSError, match="Input/output error"):
        convert_log(long, target)
    assert untouched(target)


def test_a_full_disk_leaves_what_was_there(target: Path, long: Path, small_files: None) -> None:
    with pytest.raises(OSError, match=r"File too large|No space left on device"):
        convert_log(long, target)
    assert untouched(target)


@pytest.mark.parametrize("when", [lambda: interrupt, _Once], ids=["first", "second"])
@pytest.mark.usefixtures("ctrl_c")
def test_control_c_leaves_what_was_there(target: Path, long: Path, when: Any) -> None:
    with pytest.raises(KeyboardInterrupt):
        convert_log(long, target, only=when())
    assert untouched(target)


@pytest.mark.parametrize("name", ["drive.parquet", "drive.mf4", "drive.trace", "drive.log.zst"])
@pytest.mark.parametrize("made", [convert_log, None], ids=["convert", "create"])
def test_a_library_that_is_missing_leaves_what_was_there(
    tmp_path: Path, short: Path, monkeypatch: pytest.MonkeyPatch, name: str, made: Any
) -> None:
    for module in ("pyarrow", "pyarrow.parquet", "asammdf"):
        monkeypatch.setitem(__import__("sys").modules, module, None)
    (tmp_path / "out").mkdir()
    target = tmp_path / "out" / name
    for there in (False, True):
        if there:
            target.write_bytes(OLD)
        with pytest.raises(ExtraMissing):
            convert_log(short, target) if made else create_log(target)
        assert untouched(target) if there else not os.listdir(target.parent)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
def test_a_device_is_written_itself(long: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["convert", str(long), "/dev/full", "--to", "candump"]) == 2
    assert "No space left on device; nothing of it is kept: '/dev/full'" in capsys.readouterr().err
    assert Path("/dev/full").is_char_device()


def test_a_link_stays_and_what_it_points_to_is_replaced(tmp_path: Path, short: Path) -> None:
    (tmp_path / "real.log").write_bytes(OLD)
    (tmp_path / "link.log").symlink_to("real.log")
    convert_log(short, tmp_path / "link.log")
    assert (tmp_path / "link.log").is_symlink()
    assert (tmp_path / "real.log").read_bytes() != OLD


def test_a_file_that_may_not_be_written_stays(
    target: Path, short: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write everything
    with pytest.raises(PermissionError) as raised:
        convert_log(short, target)
    assert raised.value.filename == str(target)
    assert untouched(target)


ENTRY = LogEntry(1, "can0", Frame(0x123))


def fail_in(writer: LogWriter) -> None:
    """A program that fails after the first entry."""
    with suppress(ZeroDivisionError), writer as log:
        log.write(ENTRY)
        raise ZeroDivisionError


def test_a_whole_log_is_there_once_it_is_closed(target: Path) -> None:
    with create_log(target, whole=True) as log:
        log.write(ENTRY)
        log.flush()
        assert target.read_bytes() == OLD
        assert (log.path, len(os.listdir(target.parent))) == (str(target), 2)
    with open_log(target) as found:
        assert [entry.frame for entry in found if entry.frame] == [Frame(0x123)]


def test_a_whole_log_is_dropped_after_an_error(target: Path) -> None:
    fail_in(create_log(target, whole=True))
    assert untouched(target)


def test_a_whole_log_that_failed_is_dropped_though_somebody_closes_it(
    tmp_path: Path, long: Path, small_files: None
) -> None:
    target = tmp_path / "out" / "drive.csv"
    target.parent.mkdir()
    target.write_bytes(OLD)
    log = create_log(target, whole=True)
    with open_log(long) as source, pytest.raises(OSError, match="nothing of it is kept") as raised:
        log.write_batch(next(source.batches()))
    assert raised.value.filename == str(target)
    log.close()
    log.close()
    assert untouched(target)


def test_a_growing_log_replaces_what_was_there_once_it_has_begun(target: Path) -> None:
    """A mistake leaves the old file; what is handed in later is kept, whatever comes after."""
    wrong: Any = object()
    if target.suffix in (".parquet", ".journal"):  # their heads say it
        with pytest.raises(TypeError):
            create_log(target, start_ns=wrong)
        assert untouched(target)
    fail_in(create_log(target))
    assert os.listdir(target.parent) == [target.name]
    with open_log(target) as found:
        assert [entry.frame for entry in found if entry.frame] == [Frame(0x123)]


def test_a_database_that_cannot_begin_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "drive.db"
    target.write_bytes(OLD)

    def full(*_: object, **__: object) -> None:
        raise sqlite3.OperationalError("database or disk is full")

    monkeypatch.setattr("canwire.logs.tables.sqlite_file.sqlite3.connect", full)
    with pytest.raises(OSError, match="No space left on device"):
        create_log(target)
    assert untouched(target)
