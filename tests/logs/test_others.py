"""What canwire writes is read by others, and what others write by canwire: frame by frame the same."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import can
import pytest

from canwire import Frame, LogEntry, convert_log, create_log, open_log
from tests.logs.contents import START_NS, some
from tests.missing import needs_program

DATA = Path("/work/shared/data")
CAR = Path(__file__).parents[2] / "examples" / "car-candump.log"
SUFFIXES = [".log", ".asc", ".blf", ".trc", ".mf4"]


@pytest.fixture(autouse=True)
def quiet(recwarn: pytest.WarningsRecorder) -> Iterator[None]:
    """python-can and asammdf warn of what they call deprecated among each other."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def message(frame: Frame, channel: int, direction: str) -> can.Message:
    return can.Message(
        timestamp=frame.timestamp_ns / 1e9,
        arbitration_id=frame.id,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
        is_fd=frame.fd,
        bitrate_switch=frame.bit_rate_switch,
        error_state_indicator=frame.error_state_indicator,
        dlc=len(frame.data) if frame.fd else frame.dlc,
        data=None if frame.remote else frame.data,
        channel=channel,
        is_rx=direction == "R",
    )


def facts(message: can.Message) -> tuple[object, ...]:
    data = b"" if message.is_remote_frame else bytes(message.data)
    return (message.arbitration_id, message.is_extended_id, message.is_remote_frame, message.is_fd,
            message.bitrate_switch, message.dlc, data, message.is_rx)  # fmt: skip


def facts_of(entry: LogEntry) -> tuple[object, ...]:
    frame = entry.frame
    assert frame is not None
    length = len(frame.data) if frame.fd else frame.dlc
    return (frame.id, frame.extended, frame.remote, frame.fd, frame.bit_rate_switch, length, frame.data,
            entry.direction != "T")  # fmt: skip


@pytest.mark.conforms("PF-01", "PF-02", "PF-03", "PF-04", "PF-05")
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_python_can_reads_what_we_write(tmp_path: Path, suffix: str) -> None:
    log = some(100)
    path = tmp_path / f"ours{suffix}"
    with create_log(path) as writer:
        writer.write_many(log)
    told = {"relative_timestamp": False} if suffix == ".asc" else {}
    with can.LogReader(path, **told) as reader:
        found = list(reader)
    if suffix == ".mf4":  # it reads kind by kind
        found.sort(key=lambda message: message.timestamp)
    if suffix == ".trc":  # it takes an FD frame's data length code for the length
        for one in found:
            one.dlc = len(one.data) if one.is_fd else one.dlc
    assert list(map(facts, found)) == list(map(facts_of, log))
    begin = found[0].timestamp - log[0].timestamp_ns / 1e9 if suffix in (".asc", ".trc") else 0.0
    away = [
        abs(one.timestamp - begin - entry.timestamp_ns / 1e9) for one, entry in zip(found, log, strict=True)
    ]
    assert max(away) < 1.1e-6
    assert abs(begin) < 0.002


@pytest.mark.conforms("PF-01", "PF-02", "PF-03", "PF-04", "PF-05")
@pytest.mark.parametrize("suffix", [*SUFFIXES, ".db"])
def test_we_read_what_python_can_writes(tmp_path: Path, suffix: str) -> None:
    log = some(100)
    if suffix == ".trc":  # its writer knows classic data frames
        log = [entry for entry in log if entry.frame and not (entry.frame.fd or entry.frame.remote)]
    path = tmp_path / f"theirs{suffix}"
    with can.Logger(path) as writer:
        for entry in log:
            assert entry.frame is not None
            writer.on_message_received(message(entry.frame, int(entry.channel[-1]), entry.direction or "R"))
    with open_log(path) as opened:
        found = list(opened)
        assert opened.faults == []
    if suffix == ".db":  # its writer may lose rows at stop(), has no FD and no directions
        found, log = found[:20], [entry._replace(direction=None) for entry in log[:20]]
    assert [facts_of(entry)[:3] for entry in found] == [facts_of(entry)[:3] for entry in log]
    if suffix == ".log":  # its writer leaves out for how many bytes a remote frame asks
        log = [entry for entry in log if entry.frame and not entry.frame.remote]
        found = [entry for entry in found if entry.frame and not entry.frame.remote]
    if suffix != ".db":
        assert list(map(facts_of, found)) == list(map(facts_of, log))


@pytest.mark.conforms("PF-05")
def test_asammdf_sees_bus_logging(tmp_path: Path) -> None:
    """The structures have the names that tools look for, and the values that we read ourselves."""
    import asammdf

    path = tmp_path / "ours.mf4"
    with create_log(path) as writer:
        writer.write_many(some(100))
    with asammdf.MDF(path) as mdf:
        frames = mdf.get("CAN_DataFrame")
        assert len(frames.samples) == 75
        assert frames.samples["CAN_DataFrame.ID"][:3].tolist() == [0x100, 0x101, 0x103]
        assert len(mdf.get("CAN_RemoteFrame").samples) == 25
        assert mdf.header.abs_time == START_NS


@pytest.mark.conforms("PF-07")
@needs_program("tshark")
def test_tshark_reads_our_pcapng(tmp_path: Path) -> None:
    log = some(40)
    path = tmp_path / "ours.pcapng"
    with create_log(path) as writer:
        writer.write_many(log)
    fields = ["frame.time_epoch", "can.id", "can.flags.xtd", "can.flags.rtr", "can.len", "canfd.flags.brs", "data.data",
              "frame.interface_name", "frame.packet_flags_direction"]  # fmt: skip
    words = ["tshark", "-r", str(path), "-T", "fields", "-E", "separator=;"]
    for field in fields:
        words += ["-e", field]
    rows = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True).stdout.splitlines()
    assert len(rows) == len(log)
    for row, entry in zip(rows, log, strict=True):
        time_s, id, extended, remote, length, _, data, channel, direction = row.split(";")
        frame = entry.frame
        assert frame is not None
        assert int(id, 0) == frame.id
        assert extended in ("1", "True") if frame.extended else extended in ("0", "False")
        assert remote in ("1", "True") if frame.remote else remote in ("0", "False", "")
        assert int(length) == (len(frame.data) if not frame.remote else 4)
        assert frame.remote or data.replace(":", "") == frame.data.hex()
        assert channel == entry.channel
        assert int(direction, 0) == {"R": 1, "T": 2}[entry.direction or ""]
        whole, _, rest = time_s.partition(".")
        assert int(whole) * 10**9 + int(rest) == entry.timestamp_ns


@pytest.mark.conforms("PF-06")
def test_pandas_and_duckdb_read_our_parquet(tmp_path: Path) -> None:
    import pyarrow.parquet

    log = some(100)
    path = tmp_path / "ours.parquet"
    with create_log(path) as writer:
        writer.write_many(log)
    table = pyarrow.parquet.read_table(path).to_pydict()
    assert table["time_ns"] == [entry.timestamp_ns for entry in log]
    assert table["id"] == [entry.frame.id for entry in log if entry.frame]
    assert table["data"] == [entry.frame.data for entry in log if entry.frame]
    assert table["channel"] == [entry.channel for entry in log]
    duckdb = pytest.importorskip("duckdb")
    counted = duckdb.sql(f"select channel, count(*) from '{path}' group by 1 order by 1").fetchall()
    assert counted == [("can0", 50), ("can1", 50)]


@pytest.mark.skipif(not DATA.exists(), reason="the shared data are not here")
def test_a_car_s_log_is_the_same_in_three_formats() -> None:
    found = {}
    for name in ("car-candump.log", "car-gvret.csv", "car-busmaster.log"):
        with open_log(DATA / name) as log:
            found[log.format] = [(e.frame.id, e.frame.data) for e in log if e.frame]
            assert log.faults == []
    assert list(found) == ["candump", "csv", "busmaster"]
    assert len(found["candump"]) == 12_974
    assert found["csv"] == found["candump"] == found["busmaster"]


@pytest.mark.conforms("PF-09")
@pytest.mark.parametrize("suffix", [".asc", ".blf", ".trc", ".mf4", ".csv", ".parquet", ".pcapng", ".db"])
def test_a_car_s_log_there_and_back(tmp_path: Path, suffix: str) -> None:
    """Through every format and back into candump's: line by line the same, with the directions that those demand."""
    convert_log(CAR, tmp_path / f"there{suffix}", channels={"vcan0": "can0"})
    back = convert_log(tmp_path / f"there{suffix}", tmp_path / "back.log")
    assert back.left_out == {}
    ours = [line.split()[2] for line in (tmp_path / "back.log").read_text().splitlines()]
    assert ours == [line.split()[2] for line in CAR.read_text().splitlines()]
