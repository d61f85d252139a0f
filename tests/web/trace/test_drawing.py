"""A frame drawn bit by bit."""

from __future__ import annotations

import pytest

from canwire import BitLayout, Frame
from canwire.web.trace.drawing import BITS, ERROR_DELIMITER, ERROR_FLAG, bits_of, rows_of
from tests.cases import each

pytestmark = pytest.mark.conforms("PG-02")
FRAMES = [
    Frame(0x123, b"\x11\x22"),
    Frame(0, bytes(8)),
    Frame(0x1FFFFFFF, b"\xff", extended=True),
    Frame(0x7, remote=True, dlc=4),
    Frame(0x55, bytes(64), fd=True, bit_rate_switch=True),
]


@each("frame", FRAMES, ids=str)
def test_the_bits_are_the_sender_s_but_for_the_acknowledge(frame: Frame) -> None:
    layout = BitLayout(frame)
    bits = bits_of(frame)
    drawn = [bit.level for bit in bits]
    assert drawn[: layout.ack_slot()] == list(layout.levels[: layout.ack_slot()])
    assert drawn[layout.ack_slot()] == 0
    assert [bit.kind for bit in bits].count("stuff") == sum(layout.stuffed)


@each("frame", FRAMES, ids=str)
def test_rows_hold_every_bit_once_and_spans_cover_them(frame: Frame) -> None:
    bits = bits_of(frame)
    rows = rows_of(bits)
    assert [bit for row in rows for bit in row.bits] == bits
    assert all(len(row.bits) <= BITS for row in rows)
    for row in rows:
        assert sum(span.length for span in row.spans) == len(row.bits)
        assert row.path.count("H") == len(row.bits)


def test_a_destroyed_frame_ends_in_an_error_flag_and_its_delimiter() -> None:
    """Source: ISO 11898-1:2015 10.4.4."""
    bits = bits_of(Frame(0x123, b"\x11"), error_at=20)
    assert [bit.level for bit in bits[21:]] == [0] * ERROR_FLAG + [1] * ERROR_DELIMITER
    assert {bit.kind for bit in bits[21:]} == {"error"}
    assert bits[:21] == bits_of(Frame(0x123, b"\x11"))[:21]
