"""What is read of a log has limits, whatever the file says: memory, names, and what may come out of a reader."""

from __future__ import annotations

import os
import resource
import signal
import sqlite3
import struct
import zlib
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from canwire import BadLog, BadValue, CanwireError, Frame, Log, LogEntry, LogLimits, create_log, open_log
from canwire.logs.blf import layout as b
from canwire.logs.mf4 import apart
from canwire.logs.pcapng.blocks import INTERFACE, block

pytestmark = pytest.mark.finding("faults-2 4", "faults-2 5")

MEGABYTE = 1 << 20
SMALL = LogLimits(block_bytes=MEGABYTE, channels=100)


def read(path: Path, limits: LogLimits = SMALL) -> Log:
    with open_log(path, limits=limits) as log:
        for _ in log.batches():
            pass
        return log


def container(content: bytes) -> bytes:
    packed = zlib.compress(content, 9)
    size = b.CONTAINER_HEAD.size + len(packed)
    head = b.CONTAINER_HEAD.pack(b.OBJECT_MAGIC, 16, 1, size, b.CONTAINER, b.ZLIB, len(content))
    return head + packed + b"\0" * (size % 4)


def blf(path: Path, *contents: bytes) -> Path:
    """A good log's beginning, and these containers."""
    with create_log(path) as log:
        log.write(LogEntry(1, "can0", Frame(1), "R"))
    with path.open("ab") as file:
        file.writelines(map(container, contents))
    return path


def test_a_container_unpacks_to_so_much(tmp_path: Path) -> None:
    path = blf(tmp_path / "bomb.blf", bytes(MEGABYTE + 1))
    with pytest.raises(
        BadLog, match=r"bomb.blf: byte \d+: a container that unpacks to more .*block_bytes=1048576"
    ):
        read(path)
    assert read(path, LogLimits()).channels == ["can0"]


def test_an_object_without_end_is_put_together_once(tmp_path: Path) -> None:
    """Each container brings one byte of an object that never ends: so much is copied as there is, not its square."""
    begin = b.BASE.pack(b.OBJECT_MAGIC, 16, 1, MEGABYTE - 1, 1)
    path = blf(tmp_path / "endless.blf", begin, *[b"\1"] * 2_000)
    with open_log(path, limits=SMALL) as log:
        assert sum(map(len, log.batches())) == 1
        assert ["is cut" in fault.what for fault in log.faults] == [True]


@pytest.mark.parametrize("among", ["runs", "others"])
def test_objects_in_turns_are_looked_at_once(tmp_path: Path, among: str) -> None:
    """A run of equal objects is not looked for in all that follows, after each one of another kind."""
    can = struct.pack(
        "<4sHHIIIHHQHBBI8s", b.OBJECT_MAGIC, 32, 1, 48, b.CAN_MESSAGE, 2, 0, 0, 0, 1, 0, 8, 1, bytes(8)
    )
    other = b.BASE.pack(b.OBJECT_MAGIC, 16, 1, 48, 99) + bytes(32)
    turn = can * (9 if among == "runs" else 1) + other
    path = blf(tmp_path / "turns.blf", turn * (300 if among == "runs" else 2_000))
    with open_log(path, limits=LogLimits()) as log:
        assert sum(map(len, log.batches())) == (2_701 if among == "runs" else 2_001)


def candump_of(channels: int) -> bytes:
    return b"".join(b"(%d.000000) c%d 123#11\n" % (number, number) for number in range(channels))


def pcapng_of(channels: int) -> bytes:
    section = block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1), {})
    return section + block(INTERFACE, struct.pack("<HHI", 227, 0, 0), {}) * channels


@pytest.mark.parametrize("made", [candump_of, pcapng_of])
def test_so_many_channels(tmp_path: Path, made: Callable[[int], bytes]) -> None:
    path = tmp_path / "many.log"
    path.write_bytes(made(100))
    read(path)
    path.write_bytes(made(101))
    with pytest.raises(BadLog, match="channels=100"):
        read(path)
    read(path, LogLimits())


@pytest.mark.parametrize("suffix", ["log", "csv"])
def test_a_line_without_end_is_read_in_pieces(tmp_path: Path, suffix: str) -> None:
    """Each piece is a fault, none is kept."""
    path = tmp_path / f"line.{suffix}"
    with create_log(path) as log:
        log.write(LogEntry(1_000_000, "can0", Frame(1), "R"))
    with path.open("ab") as file:
        file.write(b"(1." * MEGABYTE)
    for iterate in (Log.batches, Log.__iter__):
        with open_log(path, limits=SMALL) as log:
            entries = sum(len(one) if hasattr(one, "records") else 1 for one in iterate(log))
            assert entries == 1
            assert 3 <= log.fault_count <= 3 * MEGABYTE // SMALL.line_bytes


def test_a_databases_values_have_a_length(tmp_path: Path) -> None:
    path = tmp_path / "made.db"
    with create_log(path) as log:
        log.write(LogEntry(1, "can0", Frame(1), "R"))
    with closing(sqlite3.connect(path)) as database:
        database.executescript("alter table entries rename to kept; create table entries(time_ns, channel as "
                               "(hex(zeroblob(1000000))), direction, type, id, extended, remote, fd, brs, esi, dlc,"
                               "data, detail);"
                               "insert into entries(time_ns) select time_ns from kept;")  # fmt: skip
    with pytest.raises(BadLog, match="too big"):
        read(path)


def test_what_is_nested_without_end_is_a_fault(tmp_path: Path) -> None:
    path = tmp_path / "deep.csv"
    with create_log(path) as log:
        log.write(LogEntry(1, "can0", Frame(1), "R"))
    row = path.read_text().splitlines()[1].split(",")
    deep = '{"kind":' + "[" * 50_000
    with path.open("a") as file:
        file.write(f'{row[0]},can0,,CAN_EVENT,,,,,,,,,"{deep.replace(chr(34), chr(34) * 2)}"\n')
    assert [fault.where for fault in read(path, LogLimits()).faults] == ["line 3"]


def test_what_else_a_reader_raises_is_said_to_be_the_files_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(source: object) -> Any:
        raise struct.error("so many bytes")
        yield

    path = tmp_path / "a.log"
    path.write_bytes(candump_of(1))
    monkeypatch.setattr("canwire.logs.candump.read", fails)
    with pytest.raises(
        BadLog, match=r"a.log: nothing more of it can be read as candump \(error: so many bytes\)"
    ):
        read(path)


@pytest.mark.parametrize("field", ["line_bytes", "channels", "seconds"])
@pytest.mark.parametrize("value", [0, -1, 1 << 50, None, 1.5])
def test_a_limit_is_a_number(field: str, value: object) -> None:
    with pytest.raises((BadValue, TypeError), match=field):
        LogLimits(**{field: value})  # type: ignore[arg-type]


@pytest.mark.skipif(not apart.FORKS, reason="read in this process there")
@pytest.mark.parametrize(
    ("how", "told"),
    [
        ("crash", "ended its process"),
        ("hang", "seconds=1"),
        ("memory", "memory_bytes=67108864"),
        ("raise", "not a group"),
    ],
)
def test_what_a_foreign_reader_does_it_does_to_itself(tmp_path: Path, how: str, told: str) -> None:
    def wrong(source: Any) -> Any:
        if how == "crash":
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            os.kill(os.getpid(), signal.SIGSEGV)
        elif how == "hang":
            signal.pause()
        elif how == "memory":
            return bytes(1 << 27)
        raise BadLog("not a group")

    from canwire.logs.source import Source

    with (tmp_path / "file").open("wb+") as file:
        source = Source("a.mf4", file, LogLimits(seconds=1, memory_bytes=1 << 26))
        with pytest.raises(CanwireError, match=told):
            apart.read_apart(source, wrong)
