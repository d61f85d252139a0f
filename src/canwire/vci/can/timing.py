"""Bit timings: conversion between CANBTP or the SJA1000's registers and canwire's BitTiming.

Source: VCI V4 manual 5.2.3, 7.3.4 and 7.3.6; reference/vci.md section 3.
"""

from __future__ import annotations

from collections.abc import Callable

from canwire import BadTiming, BitTiming, Capabilities, TimingLimits
from canwire.vci.can.structures import CanBtp
from canwire.vci.structures.constants import CAN_BTMODE_RAW, CAN_BTMODE_TSM
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VCI_E_NOT_SUPPORTED, VciError

SJA1000_HZ = 16_000_000  # the oscillator for bBtReg0 and bBtReg1
SIMPLE_OFFSET = 0xFFFF  # wTDO: the second sample point has the same distance as the first (cantype.h of 4.1)


def timing_of_registers(bt_reg0: int, bt_reg1: int) -> BitTiming:
    """The bit timing of BTR0 and BTR1 of an SJA1000 at 16 MHz."""
    return BitTiming.from_btr(bt_reg0, bt_reg1, SJA1000_HZ)


def registers_of_timing(timing: BitTiming) -> tuple[int, int]:
    """BTR0 and BTR1 of an SJA1000 at 16 MHz for this timing, or for its rate and the nearest sample point.

    It returns (0, 0) if an SJA1000 cannot make the rate.
    """
    clock_hz = SJA1000_HZ // 2
    try:
        if timing.clock_hz == clock_hz:
            return timing.to_btr()
        near = BitTiming.for_bit_rate(
            timing.bit_rate, timing.sample_point, clock_hz=clock_hz, sjw=1, limits=TimingLimits.SJA1000
        )
        return near.to_btr()
    except BadTiming:
        return 0, 0


def timing_of_btp(btp: CanBtp, capabilities: Capabilities, *, data: bool) -> BitTiming:
    """The bit timing of a CANBTP with a line's clock; `data` is for the fast phase.

    Raises BadTiming for a rate that the clock cannot make and for raw values out of the line's ranges,
    VciInvalidArgument for an unknown bit of dwMode, VciNotSupported for a line without a fast phase.
    """
    if btp.mode & ~(CAN_BTMODE_RAW | CAN_BTMODE_TSM):
        raise VciError.of(
            VCI_E_INVALIDARG, f"CANBTP.dwMode {btp.mode:#x}: not CAN_BTMODE_RAW, CAN_BTMODE_TSM"
        )
    limits, clock_hz = limits_of(capabilities, data=data), capabilities.clock_hz
    raw = bool(btp.mode & CAN_BTMODE_RAW)
    make: Callable[..., BitTiming] = BitTiming.raw if raw else BitTiming.from_proportions
    before_sample = btp.bps * (1 + btp.ts1) if raw else btp.ts1
    offset = before_sample if btp.tdo == SIMPLE_OFFSET else btp.tdo
    timing = make(
        btp.bps,
        btp.ts1,
        btp.ts2,
        btp.sjw,
        clock_hz,
        limits=limits,
        tdo=min(offset, SIMPLE_OFFSET) if data else 0,
        triple_sampling=bool(btp.mode & CAN_BTMODE_TSM),
    )
    _check_offset(timing, capabilities)
    return timing


def btp_of_timing(timing: BitTiming | None) -> CanBtp:
    """The CANBTP of a timing in bit/s and ratios; an empty one for None."""
    if timing is None:
        return CanBtp()
    return CanBtp(
        mode=CAN_BTMODE_TSM if timing.triple_sampling else 0,
        bps=timing.bit_rate,
        ts1=1 + timing.tseg1,
        ts2=timing.tseg2,
        sjw=timing.sjw,
        tdo=round(timing.tdo / timing.prescaler),
    )


def limits_of(capabilities: Capabilities, *, data: bool) -> TimingLimits:
    """The ranges of a line's timing registers; raises VciNotSupported for `data` on a line without a fast phase.

    The jump width of a CAN FD controller may equal tseg2, as in the presets of cantype.h; a classic controller needs
    one quantum after the sample point, which manual 5.2.3 calls the information processing time.
    """
    ranges = capabilities.data if data else capabilities.nominal
    if ranges is None:
        raise VciError.of(VCI_E_NOT_SUPPORTED, "this line has no fast data bit rate")
    name = "this line's data phase" if data else "this line"
    return ranges.limits(name, ipt=0 if capabilities.data else 1)


def _check_offset(timing: BitTiming, capabilities: Capabilities) -> None:
    largest = capabilities.data.offset_max if capabilities.data else 0
    if timing.tdo > largest:
        clocks = f"tdo {timing.tdo} periods of the clock"
        raise BadTiming(f"{clocks}: this line delays the second sample point by {largest} at most")
