"""Two logs of one bus: the same frame at the same time."""

from __future__ import annotations

import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from canwire import Frame, connect, epoch_ns, parse_frame
from canwire.hub import wall_clock
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
            "wall clock of hub time 0", b"%d 0" % (first - 3_600_000_000_000)
        )  # the clock was set since
        assert abs(epoch_ns(one) - first) < 1_000_000_000
    with connect(time="virtual") as hub:
        assert epoch_ns(hub) == 0


class ScriptedHub:
    """A hub in a computer whose clock is the script's: the time before and after each answer, and the hub's time."""

    time = "real"

    def __init__(self, patch: pytest.MonkeyPatch, script: list[tuple[int, int, int]], note: bytes) -> None:
        clock = iter([at_ns for before_ns, after_ns, _ in script for at_ns in (before_ns, after_ns)])
        self.times = iter([hub_ns for _, _, hub_ns in script])
        self.notes = [note]
        patch.setattr(wall_clock, "time", SimpleNamespace(time_ns=lambda: next(clock)))

    def now_ns(self) -> int:
        return next(self.times)

    def note(self, name: str) -> bytes:
        assert name == "wall clock of hub time 0"
        return self.notes[-1]

    def set_note(self, name: str, value: bytes) -> None:
        assert name == "wall clock of hub time 0"
        self.notes.append(value)

    def epoch_ns(self) -> int:
        return epoch_ns(self)  # type: ignore[arg-type]


QUICKEST = 1_000_150  # what the quickest answer below says, up to 150 ns more or less
SLOW = [(1_000_000 + 900 * k, 1_000_800 + 900 * k, 350 + 900 * k) for k in range(4)]  # they say 1,000,050


@each("quickest", range(5))
@each("note", [b"", b"no numbers", b"1000150"])
def test_of_five_answers_the_quickest_says_the_time(quickest: int, note: bytes) -> None:
    script = [*SLOW[:quickest], (2_000_000, 2_000_300, 1_000_000), *SLOW[quickest:]]
    with pytest.MonkeyPatch.context() as patch:
        hub = ScriptedHub(patch, script, note)
        assert hub.epoch_ns() == QUICKEST
        assert hub.notes == [note, b"%d 150" % QUICKEST]
        assert list(hub.times) == []


@each("off_ns", [0, 1, 150, 151, 152])
@each("sign", [-1, 1])
@each("kept_error_ns", [0, 5_000_000])
def test_a_time_that_agrees_to_a_millisecond_is_kept(off_ns: int, sign: int, kept_error_ns: int) -> None:
    """A millisecond, and half the time that each of the two answers took; beyond that the clock was set."""
    kept_ns = QUICKEST + sign * (1_000_000 + kept_error_ns + off_ns)
    with pytest.MonkeyPatch.context() as patch:
        note = b"%d %d" % (kept_ns, kept_error_ns)
        hub = ScriptedHub(patch, [*SLOW, (2_000_000, 2_000_300, 1_000_000)], note)
        assert hub.epoch_ns() == (kept_ns if off_ns <= 150 else QUICKEST)
        assert len(hub.notes) == (1 if off_ns <= 150 else 2)


@pytest.mark.finding("linux 6")
@each("flags", range(4))
def test_both_digits_of_fd_flags_are_read(flags: int) -> None:
    """Older candumps write bits 0 and 1 alone, today's bit 2 (FDF) with them; we write what both kinds read."""
    frame = Frame(
        0x123, b"\1", fd=True, bit_rate_switch=bool(flags & 1), error_state_indicator=bool(flags & 2)
    )
    assert parse_frame(f"123##{flags}01") == parse_frame(f"123##{flags | 4}01") == frame
