"""The bytes of gs_usb's protocol; no I/O. All numbers are little endian.

Source: Linux drivers/net/can/usb/gs_usb.c; candleLight firmware, include/gs_usb.h.
"""

from __future__ import annotations

import struct
from enum import IntEnum, IntFlag
from typing import NamedTuple

from canwire.values.dlc import CLASSIC_LENGTHS, FD_LENGTHS, length_to_dlc
from canwire.values.frame import Frame
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.limits import TimingLimits

VENDOR_OUT, VENDOR_IN = 0x41, 0xC1  # bmRequestType: to or from an interface
ENDPOINT_IN, ENDPOINT_OUT = 0x81, 0x02
LONGEST_FRAME = 80
NOT_AN_ECHO = 0xFFFF_FFFF
BYTE_ORDER = struct.pack("<I", 0xBEEF)
IDS = {
    (0x1D50, 0x606F),
    (0x1209, 0x2323),
    (0x1CD2, 0x606F),
    (0x16D0, 0x10B8),
    (0x1209, 0xCA01),
    (0x16D0, 0x0F30),
}
"""(idVendor, idProduct) of the adapters in Linux's driver."""

_HEAD = struct.Struct("<IIBBBB")  # echo id, identifier, DLC, channel, flags, reserved
_EXTENDED, _REMOTE, _ERROR, _ID = 0x8000_0000, 0x4000_0000, 0x2000_0000, 0x1FFF_FFFF
_OVERFLOW, _FD, _BRS, _ESI = 1, 2, 4, 8
_STAMP = struct.Struct("<I")
_LIMITS = struct.Struct("<8I")


class Request(IntEnum):
    """bRequest."""

    HOST_FORMAT = 0
    BIT_TIMING = 1
    MODE = 2
    LIMITS = 4
    CONFIGURATION = 5
    DATA_BIT_TIMING = 10
    DATA_LIMITS = 11


class Ability(IntFlag):
    """What an adapter can do; the bits of the first byte and FD are also flags of its mode."""

    LISTEN_ONLY = 1 << 0
    LOOP_BACK = 1 << 1
    ONE_SHOT = 1 << 3
    STAMPS = 1 << 4
    FD = 1 << 8
    DATA_LIMITS = 1 << 10
    BUS_ERRORS = 1 << 12


class Abilities(NamedTuple):
    """Answer to LIMITS: the clock in Hz and the ranges of its registers."""

    flags: int
    clock_hz: int
    nominal: TimingLimits


class Received(NamedTuple):
    """A frame or (identifier, data) of an error frame; `stamp_us` wraps at 2**32, None without stamps."""

    echo: int
    channel: int
    frame: Frame | None
    error: tuple[int, bytes] | None
    overflow: bool
    stamp_us: int | None


def channels_of(configuration: bytes) -> int:
    """The number of channels in the answer to CONFIGURATION."""
    return configuration[3] + 1


def abilities_of(answer: bytes) -> Abilities:
    """The answer to LIMITS, 40 bytes."""
    flags, clock_hz = struct.unpack_from("<2I", answer)
    return Abilities(flags, clock_hz, _limits(answer, 8))


def data_limits_of(answer: bytes) -> TimingLimits:
    """The limits of the data phase in the answer to DATA_LIMITS, 72 bytes."""
    return _limits(answer, 40)


def _limits(answer: bytes, at: int) -> TimingLimits:
    tseg1_min, tseg1_max, tseg2_min, tseg2_max, sjw_max, least, most, _ = _LIMITS.unpack_from(answer, at)
    return TimingLimits(
        "this adapter",
        prescaler_min=least,
        prescaler_max=most,
        tseg1_min=tseg1_min,
        tseg1_max=tseg1_max,
        tseg2_min=tseg2_min,
        tseg2_max=tseg2_max,
        sjw_max=sjw_max,
        quanta_min=1 + tseg1_min + tseg2_min,
        quanta_max=1 + tseg1_max + tseg2_max,
    )


def timing_bytes(timing: BitTiming) -> bytes:
    """Propagation segment, phase segments, SJW, prescaler: of tseg1 one quantum is the propagation segment."""
    return struct.pack("<5I", 1, timing.tseg1 - 1, timing.tseg2, timing.sjw, timing.prescaler)


def mode_bytes(start: bool, flags: int = 0) -> bytes:
    return struct.pack("<2I", int(start), flags)


def frame_bytes(frame: Frame, echo: int, channel: int) -> bytes:
    """A frame for the adapter: always with 8 data bytes for a classic frame, 64 for CAN FD, padded with zeros."""
    id = frame.id | (_EXTENDED if frame.extended else 0) | (_REMOTE if frame.remote else 0)
    flags = 0
    if frame.fd:
        flags = _FD | _BRS * frame.bit_rate_switch | _ESI * frame.error_state_indicator
    dlc = length_to_dlc(len(frame.data)) if frame.fd else frame.dlc
    return _HEAD.pack(echo, id, dlc, channel, flags, 0) + frame.data.ljust(64 if frame.fd else 8, b"\0")


def received_of(packet: bytes) -> Received | None:
    """The frame in one transfer; None if it is too short or has an impossible identifier."""
    if len(packet) < _HEAD.size + 8:
        return None
    echo, id, dlc, channel, flags, _ = _HEAD.unpack_from(packet)
    fd = bool(flags & _FD)
    end = _HEAD.size + (64 if fd else 8)
    if len(packet) < end:
        return None
    length = (FD_LENGTHS if fd else CLASSIC_LENGTHS)[dlc & 15]
    data = packet[_HEAD.size : _HEAD.size + length]
    stamp = _STAMP.unpack_from(packet, end)[0] if len(packet) >= end + 4 else None
    overflow = bool(flags & _OVERFLOW)
    if id & _ERROR:
        return Received(echo, channel, None, (id & _ID, packet[12:20]), overflow, stamp)
    extended = bool(id & _EXTENDED)
    if not extended and id & _ID > 0x7FF:
        return None
    remote = bool(id & _REMOTE) and not fd
    frame = Frame(
        id & _ID,
        b"" if remote else data,
        extended=extended,
        remote=remote,
        fd=fd,
        bit_rate_switch=fd and bool(flags & _BRS),
        error_state_indicator=fd and bool(flags & _ESI),
        dlc=min(dlc, 8) if remote else None,
    )
    return Received(echo, channel, frame, None, overflow, stamp)
