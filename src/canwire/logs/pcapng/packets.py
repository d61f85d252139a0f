"""Packets of the two link types, as entries and back."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

from canwire.errors import BadText
from canwire.logs.batch import log_dtype
from canwire.logs.entry import Content
from canwire.values.dlc import FD_LENGTHS
from canwire.values.error_frame import decode_error_frame, encode_error_frame
from canwire.values.event import BusEvent
from canwire.values.frame import Frame
from canwire.values.lin.event import LinErrorKind, LinEvent, LinEventKind
from canwire.values.lin.frame import LinFrame
from canwire.values.record import (
    DLC_SHIFT,
    ERROR_STATE_INDICATOR,
    EXTENDED,
    EXTENDED_DATA_LENGTH,
    FAST_DATA_RATE,
    REMOTE,
    load_numpy,
)

if TYPE_CHECKING:
    import numpy

CAN_LINK, LIN_LINK, COOKED_LINK = 227, 212, 113
CLASSIC_SIZE, FD_SIZE = 16, 72  # of a packet: struct can_frame, struct canfd_frame
_EFF, _RTR, _ERR = 0x8000_0000, 0x4000_0000, 0x2000_0000
_BRS, _ESI, _FDF = 1, 2, 4
_HEAD = struct.Struct(">IBBxB")
_LIN_HEAD = struct.Struct(">B3xBBBB")
_COOKED = struct.Struct(">H12xH")
_COOKED_CAN = (0x000C, 0x000D)  # and CAN FD
_OUTGOING = 4
_CLASSIC_SUM, _ENHANCED_SUM = 1, 2
_NO_RESPONSE, _FRAMING, _PARITY, _CHECKSUM = 1, 2, 4, 8
_LIN_ERRORS = {
    _NO_RESPONSE: LinErrorKind.SLNORE,
    _FRAMING: LinErrorKind.OTHER,
    _PARITY: LinErrorKind.PARITY,
    _CHECKSUM: LinErrorKind.CHKSUM,
}
_LIN_SLEEPS = {0xB0B0_0001: LinEventKind.SLEEP, 0xB0B0_0002: LinEventKind.SLEEP, 0xB0B0_0004: LinEventKind.WAKEUP,
               0xB0B0_0008: LinEventKind.WAKEUP}  # fmt: skip


def content_of_packet(link: int, packet: bytes, timestamp_ns: int, sent: bool) -> Content:
    """Return the frame or event in a packet; raises BadText, BadFrame, struct.error for an invalid packet."""
    if link == LIN_LINK:
        return _lin_content(packet, timestamp_ns, sent)
    word, length, flags, code = _HEAD.unpack_from(packet)
    data = packet[8 : 8 + length]
    extended = word & _EFF != 0
    if word & _ERR:
        return decode_error_frame(word & 0x3FFF_FFFF, data, timestamp_ns)
    id = word & (0x1FFF_FFFF if extended else 0x7FF)
    if word & _RTR:
        return Frame(
            id, extended=extended, remote=True, dlc=code or min(length, 8), timestamp_ns=timestamp_ns
        )
    if len(data) < length:
        raise BadText(f"{length} data bytes, of which {len(data)} are there")
    if flags & _FDF or length > 8:
        return Frame(
            id,
            data,
            extended=extended,
            fd=True,
            bit_rate_switch=bool(flags & _BRS),
            error_state_indicator=bool(flags & _ESI),
            timestamp_ns=timestamp_ns,
        )
    dlc = code if length == 8 and 9 <= code <= 15 else length
    return Frame(id, data, extended=extended, dlc=dlc, timestamp_ns=timestamp_ns)


def of_cooked(packet: bytes, order: str) -> tuple[bytes, bool]:
    """Convert a packet of Linux's "any" interface to CAN_LINK; also returns whether it was sent.

    Its identifier has the byte order of the file. Raises BadText, struct.error.
    Source: tcpdump.org, LINKTYPE_LINUX_SLL; libpcap pcap-util.c.
    """
    kind, protocol = _COOKED.unpack_from(packet)
    if protocol not in _COOKED_CAN:
        raise BadText(f"a packet of protocol {protocol:#06x}, not of CAN")
    (word,) = struct.unpack_from(order + "I", packet, _COOKED.size)
    return word.to_bytes(4, "big") + packet[_COOKED.size + 4 :], kind == _OUTGOING


def packet_of_event(event: BusEvent) -> bytes:
    """Return the packet of an error frame."""
    id, data = encode_error_frame(event)
    return _HEAD.pack(id, 8, 0, 0) + data


def packet_of_lin(frame: LinFrame) -> bytes:
    """Return the packet of a LIN frame; a header without response is an error in a LIN packet."""
    errors = _NO_RESPONSE if frame.header_only else 0
    model = _ENHANCED_SUM if frame.enhanced else _CLASSIC_SUM
    checksum = 0 if frame.header_only else frame.checksum
    return _LIN_HEAD.pack(1, frame.length << 4 | model, frame.pid, checksum, errors) + frame.data


def _lin_content(packet: bytes, timestamp_ns: int, sent: bool) -> Content:
    _, kinds, pid, _, errors = _LIN_HEAD.unpack_from(packet)
    length, kind, model = kinds >> 4, kinds >> 2 & 3, kinds & 3
    data = packet[8 : 8 + length]
    id = pid & 0x3F
    if kind:
        number = int.from_bytes(data[:4], "big")
        if number not in _LIN_SLEEPS:
            raise BadText(f"LIN event {number:#x}: not known")
        return LinEvent(_LIN_SLEEPS[number], timestamp_ns)
    enhanced = None if not model else model == _ENHANCED_SUM
    if errors & _NO_RESPONSE and not data:
        return LinFrame(id, header_only=True, length=length, enhanced=enhanced, timestamp_ns=timestamp_ns)
    for bit, error in _LIN_ERRORS.items():
        if errors & bit:
            return LinEvent(LinEventKind.ERROR, timestamp_ns, error, id=id)
    if len(data) < length:
        raise BadText(f"{length} data bytes, of which {len(data)} are there")
    return LinFrame(id, data, enhanced=enhanced, timestamp_ns=timestamp_ns, sent=sent)


def packets_of_frames(records: numpy.ndarray, size: int) -> Any:
    """Return CAN frames as packets of this size, in rows of bytes: all classic, or all FD."""
    numpy = load_numpy()
    info = records["info"]
    fd = size == FD_SIZE
    code = info >> DLC_SHIFT & 15
    length = numpy.array(FD_LENGTHS, "u1")[code] if fd else numpy.minimum(code, 8)
    rows = numpy.zeros((len(records), size), "u1")
    word = records["id"] | numpy.where(info & EXTENDED, _EFF, 0).astype("u4")
    word |= numpy.where(info & REMOTE, _RTR, 0).astype("u4")
    rows[:, :4] = word.astype(">u4").view("u1").reshape(-1, 4)
    rows[:, 4] = length
    if fd:
        rows[:, 5] = _FDF + (info & FAST_DATA_RATE != 0) * _BRS + (info & ERROR_STATE_INDICATOR != 0) * _ESI
    else:
        rows[:, 7] = numpy.where(code > 8, code, 0)
    rows[:, 8:] = records["data"][:, : size - 8]
    return rows


def frames_of_packets(rows: Any) -> tuple[numpy.ndarray, Any]:
    """Return records of packets in rows of 16 or 72 bytes, without time and channel, and a mask of the valid ones."""
    numpy = load_numpy()
    found = numpy.zeros(len(rows), log_dtype())
    word = numpy.ascontiguousarray(rows[:, :4]).view(">u4")[:, 0].astype("u4")
    length, flags, raw = rows[:, 4], rows[:, 5], rows[:, 7]
    extended, remote = word & _EFF != 0, word & _RTR != 0
    fd = (flags & _FDF != 0) | (length > 8)
    table = numpy.full(256, 255, "u1")
    table[list(FD_LENGTHS)] = range(16)
    code = table[length]
    code = numpy.where(~fd & (length == 8) & (raw > 8) & (raw < 16), raw, code)
    found["id"] = word & 0x1FFF_FFFF
    info = code.astype("u4") << DLC_SHIFT
    for bit, there in ((EXTENDED, extended), (REMOTE, remote), (EXTENDED_DATA_LENGTH, fd),
                       (FAST_DATA_RATE, fd & (flags & _BRS != 0)),
                       (ERROR_STATE_INDICATOR, fd & (flags & _ESI != 0))):  # fmt: skip
        info |= numpy.where(there, bit, 0).astype("u4")
    found["info"] = info
    data = rows[:, 8:]
    keep = numpy.arange(data.shape[1]) < numpy.where(remote, 0, length)[:, None]
    found["data"][:, : data.shape[1]] = numpy.where(keep, data, 0)
    fit = (word & _ERR == 0) & (code < 16) & ~(fd & remote) & (length <= data.shape[1])
    return found, fit & (extended | (found["id"] <= 0x7FF))
