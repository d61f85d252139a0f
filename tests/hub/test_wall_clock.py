"""Two logs of one bus: the same frame at the same time."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from canwire import Frame, connect, epoch_ns, parse_frame
from tests.cases import each
from tests.hubs import serving


@pytest.mark.finding("linux 6")
def test_everybody_at_one_hub_has_the_same_wall_clock(tmp_path: Path) -> None:
    with (
        serving(tmp_path, time="real") as served,
        connect(served.address) as one,
        connect(served.address) as two,
    ):
        first = epoch_ns(one)
        assert [epoch_ns(two), epoch_ns(one)] == [first, first]
        before_ns = time.time_ns()
        there_ns = first + one.now_ns()
        assert before_ns - 1_000_000_000 < there_ns < time.time_ns() + 1_000_000_000
        two.set_note(
            "wall clock of hub time 0", b"%d" % (first - 3_600_000_000_000)
        )  # the clock was set since
        assert abs(epoch_ns(one) - first) < 1_000_000_000
    with connect(time="virtual") as hub:
        assert epoch_ns(hub) == 0


@pytest.mark.finding("linux 6")
@each("flags", range(4))
def test_both_digits_of_fd_flags_are_read(flags: int) -> None:
    """Older candumps write bits 0 and 1 alone, today's bit 2 (FDF) with them; we write what both kinds read."""
    frame = Frame(
        0x123, b"\1", fd=True, bit_rate_switch=bool(flags & 1), error_state_indicator=bool(flags & 2)
    )
    assert parse_frame(f"123##{flags}01") == parse_frame(f"123##{flags | 4}01") == frame
