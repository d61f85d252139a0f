"""When the next frame is due."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire import BadValue, BitLayout, Frame

if TYPE_CHECKING:
    from canwire import LineMode

Gap = Callable[[Frame], float]  # seconds from this frame to the next one
_INTERMISSION = 3  # bits that belong to a frame's time: nobody else can use them
_KEPT = 4096


def every(seconds: float) -> Gap:
    """Return a function that gives each frame the same gap, in seconds."""
    return lambda frame: seconds


def by_load(percent: float, mode: LineMode) -> Gap:
    """Gaps that let the frames use this share of the bus, for any lengths and stuff bits.

    Raises BadValue for a share out of range, or a line without a bit rate.
    """
    if not 0 < percent <= 100:
        raise BadValue(f"--load {percent:g}: more than 0, and 100 percent at most")
    if mode.timing is None:
        raise BadValue(f"--load {percent:g}: the line has no bit rate yet")
    bit_s = 1 / mode.timing.bit_rate
    data_bit_s = bit_s if mode.data_timing is None else 1 / mode.data_timing.bit_rate
    known: dict[Frame, float] = {}

    def gap(frame: Frame) -> float:
        found = known.get(frame)
        if found is None:
            if len(known) >= _KEPT:
                known.clear()
            found = known[frame] = _length_s(frame, bit_s, data_bit_s) * 100 / percent
        return found

    return gap


def _length_s(frame: Frame, bit_s: float, data_bit_s: float) -> float:
    layout = BitLayout(frame)
    fast = layout.data_bits
    return (len(layout.levels) - fast + _INTERMISSION) * bit_s + fast * data_bit_s
