"""Frames in slcan's form: the lines of the documents, streams in pieces, and rubbish."""

from __future__ import annotations

import random
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import Frame, SlcanReader, format_slcan_frame, parse_slcan_frame
from canwire.values.slcan_text import LONGEST_LINE
from tests.cases import each
from tests.effort import examples

pytestmark = pytest.mark.core

BACK = bytes.fromhex("1133")
LINES = [
    (b"t10021133", Frame(0x100, BACK)),
    (b"t0200", Frame(0x20)),
    (b"T0000010021133", Frame(0x100, BACK, extended=True)),
    (b"T1FFFFFFF8FFEEDDCCBBAA9988", Frame(0x1FFFFFFF, bytes.fromhex("FFEEDDCCBBAA9988"), extended=True)),
    (b"r1002", Frame(0x100, remote=True, dlc=2)),
    (b"R000001008", Frame(0x100, remote=True, dlc=8, extended=True)),
]
FD_LINES = [
    (b"d1009" + b"5A" * 12, Frame(0x100, b"\x5a" * 12, fd=True)),
    (b"b7FFF" + b"5A" * 64, Frame(0x7FF, b"\x5a" * 64, fd=True, bit_rate_switch=True)),
    (b"D000001001AA", Frame(0x100, b"\xaa", fd=True, extended=True)),
    (b"B00000100A" + b"00" * 16, Frame(0x100, bytes(16), fd=True, bit_rate_switch=True, extended=True)),
]
frames = st.builds(
    lambda id, extended, remote, data: Frame(
        id if extended else id & 0x7FF,
        b"" if remote else data,
        extended=extended,
        remote=remote,
        dlc=len(data) if remote else None,
    ),
    st.integers(0, 0x1FFFFFFF),
    st.booleans(),
    st.booleans(),
    st.binary(max_size=8),
)


@pytest.mark.conforms("CT-06", "CT-07", "CT-09")
@each(("line", "frame"), LINES)
def test_lines_of_the_document(line: bytes, frame: Frame) -> None:
    for fd in (False, True):
        assert parse_slcan_frame(line, fd=fd) == frame
        assert parse_slcan_frame(line[:1] + line[1:].lower(), fd=fd) == frame
    assert format_slcan_frame(frame) == line + b"\r"


@each(("line", "frame"), FD_LINES)
def test_canables_letters(line: bytes, frame: Frame) -> None:
    assert parse_slcan_frame(line, fd=True) == frame
    assert parse_slcan_frame(line) is None
    assert format_slcan_frame(frame) == line + b"\r"


@pytest.mark.conforms("CT-06", "CT-07")
@each(
    "line",
    [
        b"", b"t", b"t1", b"t100", b"t8000", b"tFFF0", b"t1009" + b"00" * 9, b"t100211", b"t1002113344", b"t10021G",
        b"t0000010021133", b"T200000000", b"T0000010", b"T000001009", b"r1009", b"r10021133", b"x1000", b"z", b"t-100",
        b"t 1002", b"t1_00", b"t+1000", b"t1002 113", b"t100:1", b"t10021133\x00", b"\xff", b"t1002\xff\xff11",
    ],
)  # fmt: skip
def test_what_is_no_frame(line: bytes) -> None:
    assert parse_slcan_frame(line) is None
    assert SlcanReader().feed(line + b"\r") == [line]


@pytest.mark.conforms("CT-09")
def test_a_remote_frame_without_a_length_asks_for_nothing() -> None:
    assert parse_slcan_frame(b"r100") == Frame(0x100, remote=True)
    assert parse_slcan_frame(b"R00000100") == Frame(0x100, remote=True, extended=True)


def test_what_is_forgiven_to_those_who_send_to_a_canable() -> None:
    assert parse_slcan_frame(b"T800001001AA", fd=True) == Frame(0x100, b"\xaa", extended=True)
    assert parse_slcan_frame(b"T800001001AA") is None
    for code, length in ((10, 16), (11, 20), (12, 24), (13, 32), (14, 48), (15, 64)):
        assert parse_slcan_frame(b"d100%d" % code + b"00" * length, fd=True) == Frame(
            0x100, bytes(length), fd=True
        )
    assert parse_slcan_frame(b"d10016" + b"00" * 64, fd=True) is None
    assert parse_slcan_frame(b"d1002" + b"00" * 3, fd=True) is None


@pytest.mark.conforms("CT-15")
def test_a_time_stamp_stands_behind_the_data() -> None:
    assert format_slcan_frame(Frame(0x100, BACK), 0x4D67) == b"t100211334D67\r"
    assert format_slcan_frame(Frame(0x100), 0) == b"t10000000\r"
    assert format_slcan_frame(Frame(0x100, remote=True, dlc=2), 0xEA5F) == b"r1002EA5F\r"


def test_a_length_code_above_eight_is_written_as_eight() -> None:
    assert format_slcan_frame(Frame(1, bytes(8), dlc=15)) == b"t0018" + b"00" * 8 + b"\r"


@pytest.mark.conforms("CT-23")
@examples(60)
@given(st.lists(frames, max_size=20), st.data())
def test_a_stream_may_be_cut_anywhere(sent: list[Frame], data: st.DataObject) -> None:
    text = b"".join(map(format_slcan_frame, sent))
    cuts = sorted(data.draw(st.lists(st.integers(0, len(text)), max_size=10)))
    for places in ([0, len(text)], range(len(text) + 1), [0, *cuts, len(text)]):
        reader = SlcanReader()
        assert [item for a, b in pairwise(places) for item in reader.feed(text[a:b])] == sent


def test_other_lines_come_as_they_stand() -> None:
    reader = SlcanReader()
    assert reader.feed(b"\r\r\rV\rS4\r\nO\r\n\n\rt1000\rF") == [
        b"", b"", b"", b"V", b"S4", b"O", b"", Frame(0x100),
    ]  # fmt: skip
    assert reader.feed(bytearray(b"\r")) == [b"F"]
    reader.feed(memoryview(b"t100"))
    reader.clear()
    assert reader.feed(b"V\r") == [b"V"]


def test_a_line_without_end_takes_no_memory() -> None:
    reader = SlcanReader()
    for _ in range(1000):
        assert reader.feed(b"t" * 1000) == []
    assert reader.dropped == 1_000_000 - LONGEST_LINE - 1
    assert reader.feed(b"\rV\r") == [b"t" * (LONGEST_LINE + 1), b"V"]
    assert reader.feed(b"x" * 1000 + b"\r") == [b"x" * (LONGEST_LINE + 1)]


@examples(60)
@given(st.lists(st.binary(max_size=300), max_size=20), st.booleans())
def test_nothing_makes_it_raise(pieces: list[bytes], fd: bool) -> None:
    whole, cut = SlcanReader(fd=fd), SlcanReader(fd=fd)
    assert whole.feed(b"".join(pieces) + b"\r") == [item for p in [*pieces, b"\r"] for item in cut.feed(p)]


def test_mutated_frames() -> None:
    chosen = random.Random(7)
    text = bytearray(b"".join(line + b"\r" for line, _ in LINES + FD_LINES))
    for _ in range(300):
        broken = bytearray(text)
        for _ in range(chosen.randrange(1, 20)):
            broken[chosen.randrange(len(broken))] = chosen.randrange(256)
        for fd in (False, True):
            for item in SlcanReader(fd=fd).feed(broken):
                if isinstance(item, Frame):
                    again = parse_slcan_frame(format_slcan_frame(item)[:-1], fd=fd)
                    assert again == item


@pytest.mark.parametrize("place", [1, 4, 5, 12, 20])
def test_hex_digits_are_these_and_no_others(place: int) -> None:
    """All 256 bytes in the place of a digit: identifier, length, data."""
    line = b"t100811223344556677FF"
    digits = b"0123456789abcdefABCDEF"
    allowed = {1: b"01234567", 4: b"8"}.get(place, digits)
    for byte in set(range(256)) - {13}:
        changed = line[:place] + bytes([byte]) + line[place + 1 :]
        found = parse_slcan_frame(changed)
        assert (found is not None) == (byte in allowed), changed
        if found is not None and place > 4:
            assert found.data == bytes.fromhex(changed[5:].decode())
