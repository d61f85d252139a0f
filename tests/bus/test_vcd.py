"""The level on the bus as VCD: exact edges by a reader of our own, whole frames by sigrok."""

from __future__ import annotations

import io
import os
import re
import subprocess
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import pytest

from canwire import Frame, Lab, parse_frame
from canwire.bus.vcd import VcdTrace
from tests.missing import find_program

pytestmark = [pytest.mark.core, pytest.mark.conforms("G-22")]

# can-protocol.md section 11, ACK slot dominant
C04 = "00010010001100000110000100010010001000001100101101111011111111"
D03 = "0001001000110010110001000100010000010010101010001011010111011111111"
# what sigrok's decoder understands: no remote frame that asks for data, no DLC above 8 in classic frames
FRAMES = [
    "123#1122",
    "000#",
    "7C0#3C20F0F0F0F0F0F0",  # 21 stuff bits, the most that an 11-bit frame was found to have
    "7EF#FFFFFFFFFFFFFFFF",
    "123#R",
    "12345678#1122334455667788",
    "12345678#R",
    "10031934#3C3C3C3C3C3C3C3C",
    "1FFFFFFF#",
    "123##011",
    "456##1000102030405060708090A0B",
    "12345678##0AABB",
    "18FF0102##1" + "00" * 20,
    "100##1" + bytes(range(64)).hex().upper(),
]
_FIELD = re.compile(r"can-1: (.*): (.*)")


def traced(path: Path, texts: Iterable[str], gap_s: float = 20e-6) -> None:
    """One sender and one receiver at 500 kbit/s and 2 Mbit/s, each frame alone on the bus."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000, data_bit_rate=2_000_000)
        sender, _ = bus.node("sender"), bus.node("receiver")
        bus.trace_levels(path)
        for text in texts:
            lab.run_for(gap_s)
            sender.send(parse_frame(text))
            lab.run_until_idle()
        lab.run_for(gap_s)


def edges_of(path: Path) -> list[tuple[int, int]]:
    """(time in ns, level) of every change in a VCD file with one wire."""
    head, _, body = path.read_text(encoding="ascii").partition("$enddefinitions $end\n")
    assert "$timescale 1 ns $end" in head
    assert "$var wire 1 ! can0 $end" in head
    edges, now_ns = [], 0
    for line in body.splitlines():
        if line.startswith("#"):
            assert int(line[1:]) >= now_ns
            now_ns = int(line[1:])
        else:
            assert line[1:] == "!"
            edges.append((now_ns, int(line[0])))
    return edges


def edges_expected(stream: str, bit_starts_ns: list[int]) -> list[tuple[int, int]]:
    levels = "1" + stream
    return [(bit_starts_ns[k], int(levels[k + 1])) for k in range(len(stream)) if levels[k] != levels[k + 1]]


def test_edges_of_a_classic_frame_are_at_bit_times(tmp_path: Path) -> None:
    traced(tmp_path / "out.vcd", ["123#1122"])
    start_ns = 20_000
    expected = edges_expected(C04, [start_ns + 2000 * k for k in range(len(C04))])
    assert edges_of(tmp_path / "out.vcd") == [(0, 1), *expected]


def test_edges_of_an_fd_frame_change_rate_in_brs_and_crc_delimiter(tmp_path: Path) -> None:
    """The nominal rate up to BRS's sample point, the data rate from there to the CRC delimiter's."""
    traced(tmp_path / "out.vcd", ["123##311"])
    edges = edges_of(tmp_path / "out.vcd")
    brs, delimiter = D03.index("1", 14 + 2), len(D03) - 10  # 0001001000110010 1: bit 16 is BRS
    assert (brs, D03[delimiter]) == (16, "1")
    before = [edge for edge in edges[1:] if edge[0] < 20_000 + 2000 * brs]
    assert before == edges_expected(D03[:brs], [20_000 + 2000 * k for k in range(brs)])
    fast = [time_ns for time_ns, _ in edges if 20_000 + 2000 * (brs + 1) < time_ns][:-2]
    assert len(fast) > 10
    assert {(later - earlier) % 500 for earlier, later in pairwise(fast)} == {0}
    # SOF to the end of EOF is 95 us: 27 nominal bits and 41 data bits of 67 + 1
    ack_start_ns = 20_000 + (len(D03) - 41) * 2000 + 41 * 500 - 9 * 2000
    assert edges[-2:] == [(ack_start_ns, 0), (ack_start_ns + 2000, 1)]


def test_an_idle_bus_has_no_edges(tmp_path: Path) -> None:
    traced(tmp_path / "out.vcd", [])
    assert edges_of(tmp_path / "out.vcd") == [(0, 1)]
    assert (tmp_path / "out.vcd").read_text().splitlines()[-1] == "#20000"


def test_tracing_changes_no_time() -> None:
    """The same frames end at the same nanosecond with and without a trace."""
    ends = []
    for trace in (False, True):
        with Lab() as lab:
            bus = lab.can_bus("can0", bit_rate=500_000, data_bit_rate=2_000_000)
            sender, receiver = bus.node("sender"), bus.node("receiver")
            if trace:
                bus.trace_levels(os.devnull)
            sender.send_many(parse_frame(text) for text in FRAMES)
            lab.run_until_idle()
            ends.append([frame.timestamp_ns for frame in receiver.receive_many(100)])
    assert ends[0] == ends[1]
    assert len(ends[0]) == len(FRAMES)


def test_sigrok_reads_the_same_frames(tmp_path: Path) -> None:
    sigrok = find_program("sigrok-cli")
    trace = tmp_path / "out.vcd"
    traced(trace, FRAMES)
    decoder = "can:nominal_bitrate=500000:fast_bitrate=2000000:sample_point=80"
    shown = subprocess.run(
        [sigrok, "-i", str(trace), "-I", "vcd:downsample=50", "-P", decoder, "-A", "can=fields:warnings"],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
        env={**os.environ, "HOME": str(tmp_path)},
    )
    expected = [parse_frame(text) for text in FRAMES]
    assert [told(block) for block in blocks_of(shown.stdout)] == [told_of(frame) for frame in expected]


Told = tuple[int, bool, bool, bool, int, bytes]


def blocks_of(text: str) -> list[str]:
    return text.split("can-1: Start of frame\n")[1:]


def told(block: str) -> Told:
    """Identifier, extended, remote, FD, DLC and data as sigrok saw them."""
    fields = dict(_FIELD.findall(block))
    fd = fields.get("Flexible data format") == "1"
    if not fd:  # libsigrokdecode 0.5.3 knows no stuff count: in FD frames it misplaces all after the data
        assert fields["ACK slot"] == "ACK"
        assert "must be" not in block
    extended = fields["Identifier extension bit"] == "extended frame"
    id = fields["Full Identifier" if extended else "Identifier"].split()[0]
    data = re.findall(r"Data byte \d+: 0x([0-9a-f]{2})", block)
    remote = not fd and fields["Remote transmission request"] == "remote frame"
    return int(id), extended, remote, fd, int(fields["Data length code"]), bytes.fromhex("".join(data))


def told_of(frame: Frame) -> Told:
    return frame.id, frame.extended, frame.remote, frame.fd, frame.dlc, frame.data


def test_many_changes_at_once_are_the_same_text_as_one_by_one() -> None:
    texts = []
    for coasts in (True, False):
        with Lab(seed=7) as lab:
            bus = lab.can_bus("can0", bit_rate=320_000, data_bit_rate=2_000_000)
            bus.wire.bits.coasts = coasts
            sender, _, other = bus.node("sender"), bus.node("receiver"), bus.node("other")
            bus.faults.noise(2e-3)
            file = io.StringIO()
            trace = VcdTrace(bus.wire, file, "can0")
            for text in FRAMES:
                sender.send(parse_frame(text))
                other.send(parse_frame("123#33"))
            lab.run_for(700e-6)
            file.write("$comment in the middle of a frame $end\n")
            lab.run_for(20e-3)
            trace.close()
            texts.append(file.getvalue())
    assert texts[0] == texts[1]
    assert texts[0].count("\n0!") > 100


def test_a_closed_trace_leaves_the_bus_at_full_speed(tmp_path: Path) -> None:
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000)
        sender, _ = bus.node("sender"), bus.node("other")
        with (tmp_path / "trace.vcd").open("w") as file:
            trace = VcdTrace(bus.wire, file, "can")
            assert bus.wire.bitwise
            trace.close()
            assert not bus.wire.bitwise
            size = file.tell()
            sender.send(Frame(1))
            lab.run_until_idle()
            trace.close()
            assert file.tell() == size
