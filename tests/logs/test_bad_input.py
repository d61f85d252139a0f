"""Truncated, corrupt and foreign files: what can be read is read, the rest is told with its place."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadLog, BadValue, BusEvent, EventKind, Frame, LogEntry, create_log, log_formats, open_log
from tests.effort import examples
from tests.logs.contents import START_NS, some

SUFFIXES = {row.name: row.suffixes[0] for row in log_formats()}
GROWING = ["candump", "csv", "pcapng", "asc", "blf", "trc", "journal"]  # readable as far as they go


def written(path: Path, count: int = 400) -> list[LogEntry]:
    log = some(count)
    with create_log(path) as writer:
        for at in range(0, count, 100):
            writer.write_many(log[at : at + 100])
            writer.flush()
    return log


@pytest.mark.parametrize("form", GROWING)
@pytest.mark.parametrize("share", [0.4, 0.77])
def test_a_cut_file_is_read_up_to_there(tmp_path: Path, form: str, share: float) -> None:
    path = tmp_path / f"log{SUFFIXES[form]}"
    log = written(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(len(whole) * share) - 3])
    with open_log(path) as opened:
        found = list(opened)
    sure = (
        found[:-1] if form in ("candump", "trc", "asc", "csv") else found
    )  # a line may be cut to another line
    assert [entry.content for entry in sure] == [entry.content for entry in log[: len(sure)]]
    assert len(found) >= 200 * (share > 0.7) + (form != "blf") * 100
    assert len(opened.faults) == opened.fault_count <= 1
    assert opened.faults or sure != found
    for fault in opened.faults:
        where, place = fault.where.split()
        assert where in ("line", "byte")
        assert int(place) > 0


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # asammdf's own __del__
@pytest.mark.parametrize("form", ["parquet", "mf4", "sqlite"])
def test_a_cut_file_with_an_index_is_one_clear_error(tmp_path: Path, form: str) -> None:
    path = tmp_path / f"log{SUFFIXES[form]}"
    written(path)
    path.write_bytes(path.read_bytes()[:1500])
    with open_log(path) as log, pytest.raises(BadLog) as raised:
        list(log)
    assert str(path) in str(raised.value)
    gc.collect()


@pytest.mark.parametrize("form", GROWING)
@examples(15, same_fixtures=True)
@given(place=st.integers(150, 4000), noise=st.binary(min_size=1, max_size=40))
def test_noise_in_the_middle_never_raises(tmp_path: Path, form: str, place: int, noise: bytes) -> None:
    """Whatever stands there: entries, or faults, or both; BadLog if nothing is left."""
    path = tmp_path / f"log{SUFFIXES[form]}"
    written(path, 100)
    whole = path.read_bytes()
    path.write_bytes(whole[:place] + noise + whole[place + len(noise) :])
    with open_log(path) as log:
        try:
            found = list(log)
        except BadLog:
            found = []
        assert found or log.faults or not whole[place:]


def test_a_candump_log_with_wrong_lines_keeps_the_others(tmp_path: Path) -> None:
    path = tmp_path / "mixed.log"
    lines = ["(1.000000) can0 123#11", "rubbish", "(1.000001) can0 123#1", "(1.000002) can1 7FF#R R", "",
             "(1.000003) lin0 10#0102", "  can0  123   [2]  11 22", "(1.5) can0 20000040#0000000000000000"]  # fmt: skip
    path.write_text("\n".join(lines) + "\n")
    with open_log(path) as log:
        found = list(log)
        assert [entry for batch in log.batches() for entry in batch] == found
        assert [fault.where for fault in log.faults] == ["line 2", "line 3"]
        assert log.channels == ["can0", "can1", "lin0"]
    assert [entry.channel for entry in found] == ["can0", "can1", "lin0", "can0", "can0"]


@pytest.mark.parametrize(
    "content", [b"", b"\x7fELF" + bytes(100), b"<html>\n<body>\n", bytes(range(256)) * 30]
)
def test_a_file_that_is_no_log_is_one_error(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "drive.blf"
    path.write_bytes(content)
    with pytest.raises(BadLog, match="no log"):
        open_log(path)


@pytest.mark.parametrize(
    ("name", "hint"), [("blv", "blf"), ("wireshark", "there are"), ("pcap", "pcapng"), ("mdf4", "mf4")]
)
def test_unknown_formats_name_near_ones(tmp_path: Path, name: str, hint: str) -> None:
    with pytest.raises(BadValue, match=hint):
        create_log(tmp_path / "out.bin", format=name)
    with pytest.raises(BadValue, match="no log format"):
        create_log(tmp_path / "out.bin")
    with pytest.raises(BadValue, match="read only"):
        create_log(tmp_path / "out.log", format="busmaster")


def test_a_thousand_faults_are_kept_and_all_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "in.log"
    path.write_text("(1.0) can0 123#11\n" + "rubbish\n" * 1500)
    with open_log(path) as log:
        assert len(list(log)) == 1
        assert (len(log.faults), log.fault_count) == (1000, 1500)


def test_times_before_a_blf_s_beginning(tmp_path: Path) -> None:
    """Its objects count upwards from the beginning; a later batch may have earlier times, as two channels have them."""
    path = tmp_path / "drive.blf"
    with create_log(path) as writer:
        for time_ns in (START_NS, START_NS - 5_000_000):
            entries = [
                LogEntry(time_ns, "can0", Frame(0x123, timestamp_ns=time_ns), "R"),
                LogEntry(time_ns, "can0", BusEvent(EventKind.STATE, time_ns)),
            ]
            writer.write_many(entries)
    assert writer.left_out == {"times before the log's beginning (that is written)": 2}
    with open_log(path) as log:
        assert [entry.timestamp_ns for entry in log] == [START_NS] * 4
        assert log.faults == []
