"""Logs as other people's programs write them; each of these once gave wrong data, or lost some."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import can
import pytest

from canwire import BusEvent, ErrorKind, ErrorState, EventKind, Frame, create_log, open_log
from canwire.logs.entry import LogEntry

ASC = """date Sat Sep 30 15:06:13.191 2017
base {base}  timestamps absolute
{line}
"""


def frames_in(path: Path) -> list[Frame]:
    with open_log(path) as log:
        found = [entry.frame for entry in log if entry.frame is not None]
        assert not log.faults
    return found


def asc(folder: Path, base: str, line: str) -> Path:
    path = folder / "others.asc"
    path.write_text(ASC.format(base=base, line=line))
    return path


def test_decimal_bytes_of_can_fd(tmp_path: Path) -> None:
    line = (
        "0.1 CANFD 1 Rx 291 1 0 3 3 16 255 10 130000 130 303000 e0006659 46500250 4b140250 20011736 2001040d"
    )
    (frame,) = frames_in(asc(tmp_path, "dec", line))
    assert (frame.id, frame.data) == (291, bytes([16, 255, 10]))


@pytest.mark.parametrize("tail", ["r", "r Length = 0 BitCount = 64", "r 4", "r 8 Length = 0 BitCount = 64"])
def test_remote_frames_without_a_length(tmp_path: Path, tail: str) -> None:
    (frame,) = frames_in(asc(tmp_path, "hex", f"2.5 1 100 Tx {tail}"))
    assert (frame.id, frame.remote, frame.dlc) == (
        0x100,
        True,
        int(tail.split()[1]) if tail[2:3].isdigit() else 0,
    )


def test_mf4_with_identifiers_of_11_bits_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A CANedge's: the column of identifiers has 16 bits."""
    pytest.importorskip("asammdf")
    from canwire.logs.mf4 import writing

    columns = writing._columns

    def narrow(*arguments: object) -> object:
        samples = columns(*arguments)  # type: ignore[arg-type]
        kinds = [
            (name, "<u2" if name.endswith(".ID") else samples.dtype[name]) for name in samples.dtype.names
        ]
        return samples.astype(kinds)

    monkeypatch.setattr(writing, "_columns", narrow)
    path = tmp_path / "canedge.mf4"
    with create_log(path) as log:
        log.write(LogEntry(10**18, "can0", Frame(0x7FF, b"\x01"), "R"))
    assert frames_in(path) == [Frame(0x7FF, b"\x01")]


def test_the_last_container_of_a_cut_blf(tmp_path: Path) -> None:
    path = tmp_path / "whole.blf"
    with create_log(path) as log:
        for number in range(4000):
            data = (number * 2654435761 % 2**64).to_bytes(8, "big")
            log.write(LogEntry(10**18 + number * 1000, "can0", Frame(number % 2048, data), "R"))
    whole = path.read_bytes()
    cut = tmp_path / "cut.blf"
    cut.write_bytes(whole[: len(whole) * 3 // 4])
    with open_log(cut) as log:
        found = sum(1 for entry in log if entry.frame is not None)
        assert log.fault_count >= 1
    assert 2000 < found < 4000


@pytest.mark.parametrize("suffix", [".csv", ".db"])
def test_python_can_s_error_frames_without_a_class(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"others{suffix}"
    writer = can.Logger(path)
    writer(can.Message(is_error_frame=True, timestamp=1.5))
    writer(can.Message(arbitration_id=0x12, is_extended_id=False, timestamp=2.5))
    writer.stop()
    if suffix == ".db":
        with sqlite3.connect(path) as database:
            assert database.execute("select count(*) from messages").fetchone() == (2,)
    with open_log(path) as log:
        error, frame = (entry.content for entry in log)
        assert not log.faults
    assert isinstance(error, BusEvent)
    assert error.error is ErrorKind.OTHER
    assert isinstance(frame, Frame)


def test_pandas_reads_identifiers_as_whole_numbers(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    path = tmp_path / "drive.parquet"
    with create_log(path) as log:
        log.write(LogEntry(1, "can0", Frame(0x123), "R"))
        log.write(LogEntry(2, "can0", BusEvent(kind=1, timestamp_ns=2, error=ErrorKind.STUFF)))  # type: ignore[arg-type]
    table = pandas.read_parquet(path)
    assert str(table["id"].dtype) == "UInt32"
    assert table["id"][0] == 0x123


def test_others_find_our_errors_and_no_other_events_in_asc(tmp_path: Path) -> None:
    """Readers of ASC know "ErrorFrame"; changes of a node's state are comments to them."""
    path = tmp_path / "ours.asc"
    with create_log(path) as log:
        log.write(
            LogEntry(1_000, "can0", BusEvent(EventKind.ERROR, error=ErrorKind.STUFF, timestamp_ns=1_000))
        )
        log.write(
            LogEntry(2_000, "can0", BusEvent(EventKind.STATE, state=ErrorState.BUS_OFF, timestamp_ns=2_000))
        )
    error, state = path.read_text().splitlines()[-3:-1]
    assert error.split()[1:3] == ["1", "ErrorFrame"]
    assert state.startswith("//")
