"""IFLA_CAN_*: the attributes of a controller, in replies and in requests.

Source: linux/can/netlink.h.
"""

from __future__ import annotations

import errno
import struct
from dataclasses import replace
from typing import TYPE_CHECKING

from canwire import BadTiming, BitTiming, ErrorState, WantedMode
from canwire.socketcan.netlink.messages import attribute, attributes_in
from canwire.socketcan.ports import refuse

if TYPE_CHECKING:
    from canwire import Capabilities, LineMode, LineStatus

(
    TIMING,
    TIMING_LIMITS,
    CLOCK,
    STATE,
    MODES,
    RESTART_MS,
    RESTART,
    COUNTERS,
    DATA_TIMING,
    DATA_TIMING_LIMITS,
) = range(1, 11)
LISTEN_ONLY, THREE_SAMPLES, ERROR_REPORTS, FD, FD_NON_ISO = 0x2, 0x4, 0x10, 0x20, 0x80
_SETTABLE = LISTEN_ONLY | ERROR_REPORTS | FD | FD_NON_ISO
_TIMING = struct.Struct("<8I")  # struct can_bittiming
_LIMITS = struct.Struct("<16s8I")  # struct can_bittiming_const
_WORD, _PAIR, _HALVES = struct.Struct("<I"), struct.Struct("<II"), struct.Struct("<HH")
_STATISTICS = struct.Struct("<6I")  # struct can_device_stats


def shown(
    capabilities: Capabilities, mode: LineMode, status: LineStatus, state: ErrorState, restart_ms: int
) -> bytes:
    """IFLA_INFO_DATA of a line with these settings."""
    flags = (LISTEN_ONLY if mode.listen_only else 0) | (ERROR_REPORTS if mode.error_frames else 0)
    flags |= (FD if mode.data_timing is not None else 0) | (0 if mode.iso_fd else FD_NON_ISO)
    flags |= THREE_SAMPLES if mode.timing is not None and mode.timing.triple_sampling else 0
    parts = [
        _timing(TIMING, mode.timing),
        _limits(TIMING_LIMITS, capabilities, of_data=False),
        attribute(CLOCK, _WORD.pack(capabilities.clock_hz)),
        attribute(STATE, _WORD.pack(int(state))),
        attribute(MODES, _PAIR.pack(0, flags)),
        attribute(RESTART_MS, _WORD.pack(restart_ms)),
        attribute(COUNTERS, _HALVES.pack(status.tec & 0xFFFF, status.rec & 0xFFFF)),
        _timing(DATA_TIMING, mode.data_timing),
        _limits(DATA_TIMING_LIMITS, capabilities, of_data=True),
    ]
    return b"".join(parts)


def statistics(status: LineStatus) -> bytes:
    """IFLA_INFO_XSTATS; counters that a line does not have are 0."""
    return _STATISTICS.pack(status.errors, 0, 0, 0, status.arbitration_losses, 0)


def asked(data: bytes, before: WantedMode, capabilities: Capabilities) -> WantedMode:
    """The mode that IFLA_INFO_DATA of a change requests; raises OSError."""
    wanted = before
    for kind, value in attributes_in(data).items():
        if kind in (TIMING, DATA_TIMING):
            wanted = _with_timing(wanted, value, capabilities, of_data=kind == DATA_TIMING)
        elif kind == MODES:
            wanted = _with_modes(wanted, *_unpacked(_PAIR, value))
        elif kind not in (RESTART_MS, RESTART):  # which links.py looks at
            raise refuse(errno.EOPNOTSUPP)
    return wanted


def restart_ms_asked(data: bytes) -> int | None:
    """The requested restart-ms; None: unchanged. Raises OSError."""
    value = attributes_in(data).get(RESTART_MS)
    return None if value is None else _unpacked(_WORD, value)[0]


def asks_for_restart(data: bytes) -> bool:
    return RESTART in attributes_in(data)


def _with_timing(
    wanted: WantedMode, value: bytes, capabilities: Capabilities, *, of_data: bool
) -> WantedMode:
    rate, sample_point, quantum_ns, prop, phase1, phase2, sjw, _ = _unpacked(_TIMING, value)
    try:
        if rate:
            search = capabilities.data_timing if of_data else capabilities.timing
            timing = search(rate, sample_point / 1000 if sample_point else None)
        else:
            prescaler = round(quantum_ns * capabilities.clock_hz / 1e9)
            timing = BitTiming(
                prescaler, prop + phase1, phase2, sjw or 1, clock_hz=capabilities.clock_hz, prop=prop
            )
    except BadTiming:
        raise refuse(errno.EINVAL) from None
    if of_data:
        return replace(wanted, data_bit_rate=None, data_timing=timing)
    return replace(wanted, bit_rate=None, timing=timing)


def _with_modes(wanted: WantedMode, mask: int, flags: int) -> WantedMode:
    if mask & flags & ~_SETTABLE:
        raise refuse(errno.EOPNOTSUPP)
    if mask & LISTEN_ONLY:
        wanted = replace(wanted, listen_only=bool(flags & LISTEN_ONLY))
    if mask & FD:
        wanted = replace(wanted, fd=bool(flags & FD))
    if mask & FD_NON_ISO:
        wanted = replace(wanted, iso_fd=not flags & FD_NON_ISO)
    return wanted


def _unpacked(layout: struct.Struct, value: bytes) -> tuple[int, ...]:
    if len(value) < layout.size:
        raise refuse(errno.EINVAL)
    return layout.unpack_from(value)


def _timing(kind: int, timing: BitTiming | None) -> bytes:
    if timing is None:
        return b""
    packed = _TIMING.pack(
        timing.bit_rate,
        round(timing.sample_point * 1000),
        timing.quantum_ps // 1000,
        timing.prop or 0,
        timing.phase1,
        timing.tseg2,
        timing.sjw,
        timing.prescaler,
    )
    return attribute(kind, packed)


def _limits(kind: int, capabilities: Capabilities, *, of_data: bool) -> bytes:
    ranges = capabilities.data if of_data else capabilities.nominal
    if ranges is None:
        return b""
    (brp_min, brp_max), (one_min, one_max), (two_min, two_max) = ranges.prescaler, ranges.tseg1, ranges.tseg2
    packed = _LIMITS.pack(b"canwire", one_min, one_max, two_min, two_max, ranges.sjw[1], brp_min, brp_max, 1)
    return attribute(kind, packed)
