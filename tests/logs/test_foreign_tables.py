"""Tables of other programs: CSV of named columns, Microchip's, CARBUS Analyzer's, python-can's, SavvyCAN's."""

from __future__ import annotations

from pathlib import Path

import can
import pytest

from canwire import (
    BadLog,
    BusEvent,
    ErrorKind,
    EventKind,
    Frame,
    LogEntry,
    create_log,
    format_frame,
    open_log,
)
from tests.logs.contents import START_NS, some

pytestmark = pytest.mark.conforms("N-56", "PF-06")
MICROCHIP = """//---------------------------------
Microchip Technology Inc.
CAN BUS Analyzer
Logging Started: 23/9/2015 22:17:43
//---------------------------------
166064;RX;0x0000021A;2;0xFE;0x36;
166074;TX;0x18DAF110;0;
"""
CARBUS = (
    "@ TEXT @ {version} @ 64 @ 0 @ 2 @ 7283 @ 00:00:07.283 @\r# $LocalTime=16:39:55.817\r"
    "10,{fraction}\t1\t00000005\t17333210\t3\t3C A6 00      \t00000000\t<  \t\r"
    "11,{fraction}\t2\t00000030\t07F\t16\t" + "01 " * 16 + "\t00000000\t\t\r"
)


def shown(path: Path, faults: int = 0) -> list[tuple[int, str, str, str | None]]:
    with open_log(path) as log:
        found = [
            (entry.timestamp_ns, entry.channel, format_frame(entry.frame), entry.direction)
            for entry in log
            if entry.frame
        ]
        assert len(log.faults) == faults
    return found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("ID,Data Bytes\n0000021A,FE 36 12 \n", (0, "can0", "21A#FE3612", None)),
        (
            "Time (ms);Bus;ID (dec);Ext;Dir;DLC;D0;D1;D2\n1.5;2;291;0;Tx;3;01;02;FF\n",
            (1_500_000, "can2", "123#0102FF", "T"),
        ),
        (
            '"Time","Identifier (hex)","Format","Flags","Data (hex)"\n"0,5","18DAF110","Ext","","3344"\n',
            (500_000_000, "can0", "18DAF110#3344", None),
        ),
        (
            "timestamp_us\tcan_id\tdirection\tpayload\n7\t0x00000123\trx\t11-22\n",
            (7000, "can0", "123#1122", "R"),
        ),
        ("time,channel,id,rtr,dlc,data\n2,door,7FF,1,3,\n", (2_000_000_000, "door", "7FF#R3", None)),
        ("t,id,fd,brs,data\n0,100,1,1," + "AB" * 12 + "\n", (0, "can0", "100##1" + "AB" * 12, None)),
        (
            "Date,ID,Data\n2023-11-14T22:13:20.000001,00001234,01\n",
            (START_NS // 10**9 * 10**9 + 1000, "can0", "00001234#01", None),
        ),
    ],
)
def test_columns_tell_by_their_names(
    tmp_path: Path, text: str, expected: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    import time

    monkeypatch.setenv("TZ", "UTC")
    time.tzset()
    (tmp_path / "theirs.csv").write_text(text)
    assert shown(tmp_path / "theirs.csv") == [expected]


def test_rows_that_are_none_are_faults(tmp_path: Path) -> None:
    path = tmp_path / "theirs.csv"
    path.write_text("ID;LEN;Data\n100;2;01 02\n100;3;01 02\nwhat;0;\n800;1;01\n")
    assert [row[2] for row in shown(path, faults=2)] == ["100#0102", "00000800#01"]


@pytest.mark.parametrize("header", ["Name,Value\n1,2\n", "ID\n100\n", "Data,Time\n00,1\n"])
def test_a_table_without_frames_is_no_log(tmp_path: Path, header: str) -> None:
    (tmp_path / "x.csv").write_text(header)
    with pytest.raises(BadLog, match="no log that canwire knows"):
        open_log(tmp_path / "x.csv")


def test_microchip(tmp_path: Path) -> None:
    path = tmp_path / "analyzer.log"
    path.write_text(MICROCHIP + "166084;RX;0x1;2;0x01;\nwhat\n")
    assert shown(path, faults=2) == [
        (166_064_000_000, "can0", "21A#FE36", "R"),
        (166_074_000_000, "can0", "18DAF110#", "T"),
    ]


@pytest.mark.parametrize(("version", "fraction", "ns"), [(2, "016", 16_000_000), (3, "469067", 469_067_000)])
def test_carbus_analyzer(tmp_path: Path, version: int, fraction: str, ns: int) -> None:
    path = tmp_path / "analyzer.trc"
    path.write_bytes((CARBUS.format(version=version, fraction=fraction) + "12,0\t1\t4\n").encode())
    assert shown(path, faults=1) == [
        (10_000_000_000 + ns, "can0", "17333210#3CA600", None),
        (11_000_000_000 + ns, "can1", "07F##1" + "01" * 16, None),
    ]


@pytest.mark.parametrize(("form", "suffix"), [("python-can-csv", ".csv"), ("python-can-db", ".db")])
def test_python_can_reads_its_own_tables(tmp_path: Path, form: str, suffix: str) -> None:
    """Frames with flags that the tables have no column for come as what is left of them."""
    path = tmp_path / f"ours{suffix}"
    error = BusEvent(EventKind.ERROR, START_NS, error=ErrorKind.STUFF)
    log = [*some(40), LogEntry(START_NS, "can0", error, "R")]
    with create_log(path, format=form) as writer:
        writer.write_many(log)
    assert set(writer.left_out) <= {
        "directions", "names of channels", "CAN FD flags (data of more than 8 bytes tell)",
        "time stamps' nanoseconds below a microsecond",
    }  # fmt: skip
    with can.LogReader(path) as reader:
        theirs = list(reader)
    frames = [entry.frame for entry in log if entry.frame]
    told = [(one.arbitration_id, one.is_extended_id, one.is_remote_frame, bytes(one.data)) for one in theirs]
    assert told[:-1] == [(one.id, one.extended, one.remote, one.data) for one in frames]
    assert theirs[-1].is_error_frame
    with open_log(path) as opened:
        ours = list(opened)
        assert not opened.faults
    away = [abs(one.timestamp_ns - entry.timestamp_ns) for one, entry in zip(ours, log, strict=True)]
    assert max(away) < 1000
    assert isinstance(ours[-1].content, BusEvent)


def test_savvycan_s_table_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "ours.csv"
    log = [
        LogEntry(1_500_000, "can0", Frame(0x123, b"\x11\x22", timestamp_ns=1_500_000), "R"),
        LogEntry(2_000_000, "can1", Frame(0x123, bytes(12), extended=True, fd=True, timestamp_ns=2_000_000), "T"),
        LogEntry(2_500_000, "can1", Frame(1, remote=True), "R"),
        LogEntry(3_000_000, "can1", BusEvent(EventKind.ERROR), None),
    ]  # fmt: skip
    with create_log(path, format="gvret", dated=False) as writer:
        writer.write_many(log)
    lines = path.read_text().splitlines()
    assert lines[1:] == ["1500,00000123,false,Rx,0,2,11,22,", "2000,00000123,true,Tx,1,12," + "00," * 12]
    assert writer.left_out == {
        "error frames and events": 1, "remote frames": 1, "CAN FD flags (data of more than 8 bytes tell)": 1,
    }  # fmt: skip
    with open_log(path) as opened:
        assert list(opened) == log[:2]
