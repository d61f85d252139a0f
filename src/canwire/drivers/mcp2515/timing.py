"""Bit timings as CNF1 to CNF3 hold them. Source: DS20001801 chapter 5."""

from __future__ import annotations

from canwire.chips.mcp2515 import register_map as m
from canwire.errors import BadTiming
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.limits import TimingLimits

# PRSEG and PHSEG1 have 1..8 quanta each; PHSEG2 is longer than SJW, and not longer than the two together.
LIMITS = TimingLimits("MCP2515", 64, 16, 8, 4, 8, 25, tseg1_min=2, tseg2_min=2, ipt=1)
_SEGMENT = 8


def cnf_of(timing: BitTiming, oscillator_hz: int) -> tuple[int, int, int]:
    """CNF1, CNF2 and CNF3 for this timing, or for its rate and sample point with this chip's oscillator.

    Raises BadTiming if the registers cannot hold the timing or the chip forbids it.
    """
    clock_hz = oscillator_hz // 2
    if timing.clock_hz != clock_hz:
        timing = BitTiming.for_bit_rate(
            timing.bit_rate, timing.sample_point, clock_hz=clock_hz, limits=LIMITS
        )
    tseg1, phase2, jump = timing.tseg1, timing.tseg2, timing.sjw
    LIMITS.check(timing.prescaler, tseg1, phase2, jump)
    if phase2 > tseg1:
        raise BadTiming(
            f"tseg2 {phase2}: an MCP2515 needs PROP + PHASE1 to be at least as long, and it is {tseg1}"
        )
    jump = min(jump, phase2 - 1)
    phase1 = min(max(timing.phase1, 1, tseg1 - _SEGMENT), _SEGMENT, tseg1 - 1)
    prop = tseg1 - phase1
    sampling = m.CNF2_SAM if timing.triple_sampling else 0
    return (
        jump - 1 << m.CNF1_SJW_SHIFT | timing.prescaler - 1,
        m.CNF2_BTLMODE | sampling | phase1 - 1 << m.CNF2_PHSEG1_SHIFT | prop - 1,
        phase2 - 1,
    )
