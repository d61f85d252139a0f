"""Lengths of many frames at once are those that `BitLayout` finds bit by bit."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canwire import BitLayout, Frame, frames_to_array
from canwire.logs.statistics.wire_bits import INTERMISSION, wire_bits
from tests.logs.contents import frames

pytestmark = pytest.mark.conforms("PC-08")


def measured(frame: Frame) -> tuple[int, int]:
    layout = BitLayout(frame)
    return len(layout.levels) + INTERMISSION, layout.data_bits


@settings(max_examples=60, deadline=None)
@given(st.lists(frames(), max_size=30))
def test_of_any_frames(some: list[Frame]) -> None:
    bits, fast = wire_bits(frames_to_array(some))
    assert list(zip(bits.tolist(), fast.tolist(), strict=True)) == [measured(frame) for frame in some]


@pytest.mark.parametrize("fill", [b"\x00", b"\xff", b"\x1f", b"\xe0", b"\x0f"])
@pytest.mark.parametrize("extended", [False, True])
def test_of_frames_full_of_stuff_bits(fill: bytes, extended: bool) -> None:
    ids = (0, 0x7C0, 0x7FF, *((0x1FFFFFFF, 0x1F07C1F0) if extended else ()))
    some = [Frame(id, fill * length, extended=extended) for id in ids for length in range(9)]
    some += [Frame(id, fill * 64, extended=extended, fd=True, bit_rate_switch=True) for id in ids]
    bits, fast = wire_bits(frames_to_array(some))
    assert list(zip(bits.tolist(), fast.tolist(), strict=True)) == [measured(frame) for frame in some]
