"""Lines and packets as other programs write them; each of these was once refused, or read wrongly."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from canwire import Frame, LinFrame, LogEntry, format_frame, open_log

pytestmark = pytest.mark.conforms("N-56")
BUSMASTER = """***BUSMASTER Ver 2.0.0***
***PROTOCOL CAN***
***START DATE AND TIME 1:1:1970 01:00:00:500***
***HEX***
***{mode} MODE***
***<Time><Tx/Rx><Channel><CAN ID><Type><DLC><DataBytes>***
01:00:01:0000 Tx 1 021 s 2 AB 01
00:00:00:1010 Rx 2 12345678 x 0
"""
J1939 = """***BUSMASTER 2.5.0***
***PROTOCOL J1939***
12:38:30:5344 1 18eeff00 0x00EE00 ACL 00  FF  006 Tx 8 01 00 00 00 00 00 00 80
12:38:31:0000 2 18eaff01 0x00EA00 RQST 01  FF  006 Rx 3 00 EE 00
12:38:32:0000 2 18ebff01 0x00EB00 BROADCAST 01  FF  006 Rx 9 00 EE 00 00 00 00 00 00 00
"""
LIN = """***BUSMASTER Ver 3.1.0***
***PROTOCOL LIN***
13:11:35:4424 Tx 1 0x001 2 FF 01  0xFD (Enhanced)
13:11:35:4492 Rx 2 0x03C 1 12  0xED (Classic)
"""
HOUR_NS = 3600 * 10**9


def entries(path: Path, faults: int = 0) -> list[LogEntry]:
    with open_log(path) as log:
        found = list(log)
        assert log.fault_count == faults, log.faults
    return found


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("mode", "times_ns"),
    [
        ("SYSTEM", [HOUR_NS + 1_000_000_000, 101_000_000]),
        ("ABSOLUTE", [2 * HOUR_NS + 1_500_000_000, HOUR_NS + 601_000_000]),
        ("RELATIVE", [2 * HOUR_NS + 1_500_000_000, 2 * HOUR_NS + 1_601_000_000]),
    ],
)
def test_what_times_of_busmaster_count_from(mode: str, times_ns: list[int], tmp_path: Path) -> None:
    """The day's beginning, the session's, or the line before."""
    found = entries(written(tmp_path, "busmaster.log", BUSMASTER.format(mode=mode)))
    assert [(entry.timestamp_ns, entry.channel, entry.direction) for entry in found] == [
        (times_ns[0], "can1", "T"),
        (times_ns[1], "can2", "R"),
    ]
    assert [format_frame(entry.frame) for entry in found if entry.frame] == ["021#AB01", "12345678#"]


def test_a_busmaster_log_without_its_first_lines(tmp_path: Path) -> None:
    text = "\n***HEX***\n" + BUSMASTER.format(mode="RELATIVE").split("***HEX***\n")[1]
    assert [entry.timestamp_ns for entry in entries(written(tmp_path, "cut.log", text))] == [
        HOUR_NS + 10**9,
        HOUR_NS + 1_101_000_000,
    ]


def test_frames_of_j1939_in_busmaster(tmp_path: Path) -> None:
    """A message of several frames is none of them."""
    found = entries(written(tmp_path, "j1939.log", J1939), faults=1)
    assert [
        (entry.channel, format_frame(entry.frame), entry.direction) for entry in found if entry.frame
    ] == [
        ("can1", "18EEFF00#0100000000000080", "T"),
        ("can2", "18EAFF01#00EE00", "R"),
    ]


def test_frames_of_lin_in_busmaster(tmp_path: Path) -> None:
    found = [entry.content for entry in entries(written(tmp_path, "lin.log", LIN))]
    assert all(isinstance(frame, LinFrame) for frame in found)
    assert [
        (frame.id, frame.data, frame.enhanced, frame.sent) for frame in found if isinstance(frame, LinFrame)
    ] == [
        (0x01, b"\xff\x01", True, True),
        (0x3C, b"\x12", False, False),
    ]


def test_data_that_look_like_a_hash_sign_in_candump_a(tmp_path: Path) -> None:
    text = "  can0  TX - -  18DA28F1   [3]  03 23 08                  '.#.'\n"
    assert [
        format_frame(entry.frame) for entry in entries(written(tmp_path, "a.log", text)) if entry.frame
    ] == ["18DA28F1#032308"]


def test_times_that_are_padded_with_blanks(tmp_path: Path) -> None:
    """As candump of can-utils before 2010 printed them."""
    path = written(tmp_path, "padded.log", "(         0.191254) can0 06314000#40\n")
    assert [(entry.timestamp_ns, format_frame(entry.frame)) for entry in entries(path) if entry.frame] == [
        (191_254_000, "06314000#40")
    ]


def test_more_bytes_than_a_classic_frame_has_in_asc(tmp_path: Path) -> None:
    """Some converters write frames of CAN FD like that; eight of their bytes are no frame."""
    head = "date Thu Jan 01 00:00:00.000 1970\nbase hex  timestamps absolute\n"
    lines = [
        f"0.{number} 1 123 Rx d 9 01 02 03 04 05 06 07 08{rest}\n"
        for number, rest in ((1, " 09 0A 0B 0C"), (2, ""), (3, " Length = 1"))
    ]
    found = entries(written(tmp_path, "long.asc", head + "".join(lines)), faults=1)
    assert [entry.timestamp_ns for entry in found] == [200_000_000, 300_000_000]


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("suffix", ["pcap", "pcapng"])
def test_captures_of_the_interface_any(suffix: str, order: str, tmp_path: Path) -> None:
    """Linux' cooked packets: the identifier has the byte order of the file; other protocols are faults."""
    packets = [_cooked(order, 0, 0x000C, 0x123, b"\x11\x22"), _cooked(order, 4, 0x000C, 0x8000_0001, b"")]
    packets.append(_cooked(order, 0, 0x0800, 0, bytes(8)))
    path = tmp_path / f"any.{suffix}"
    path.write_bytes(_pcap(order, packets) if suffix == "pcap" else _pcapng(order, packets))
    assert [(entry.content, entry.direction) for entry in entries(path, faults=1)] == [
        (Frame(0x123, b"\x11\x22", timestamp_ns=1_000_000_000), "R"),
        (Frame(1, extended=True, timestamp_ns=1_000_000_000), "T"),
    ]


def _cooked(order: str, kind: int, protocol: int, id: int, data: bytes) -> bytes:
    return (
        struct.pack(">HHH8xH", kind, 280, 0, protocol)
        + struct.pack(order + "IB3x", id, len(data))
        + data.ljust(8, b"\0")
    )


def _pcap(order: str, packets: list[bytes]) -> bytes:
    head = struct.pack(order + "IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 113)
    return head + b"".join(struct.pack(order + "IIII", 1, 0, len(one), len(one)) + one for one in packets)


def _pcapng(order: str, packets: list[bytes]) -> bytes:
    found = _block(order, 0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, 0, -1))
    found += _block(order, 1, struct.pack(order + "HHI", 113, 0, 0))
    found += _block(order, 0x0BAD, b"")  # the smallest block there can be, of a kind that nobody knows
    for one in packets:
        found += _block(order, 6, struct.pack(order + "IIIII", 0, 0, 1_000_000, len(one), len(one)) + one)
    return found


def _block(order: str, kind: int, body: bytes) -> bytes:
    size = struct.pack(order + "I", 12 + len(body))
    return struct.pack(order + "I", kind) + size + body + size
