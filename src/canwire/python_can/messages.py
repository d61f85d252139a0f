"""Converts python-can's messages to the hub's records and back.

The `dlc` of a message is its length in bytes, as everywhere in python-can. Of a classic frame with a DLC of 9 to 15
and of a remote frame it is the code itself. Source: python-can 4.6 message.py; values/record.py.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache
from typing import Any

import can

from canwire import (
    BadFrame,
    BusEvent,
    EventKind,
    dlc_to_length,
    encode_error_frame,
    length_to_dlc,
)

_FAST_DATA_RATE = 1 << 11
_FD = 1 << 10
_ESI = 1 << 12
_DLC_SHIFT = 16
_OVERRUN = 1 << 20
_REMOTE = 1 << 22
_EXTENDED = 1 << 23
_TYPE = 0xFF
_RECORD = struct.Struct("<QII64s")
_IDENTIFIER = 0x1FFF_FFFF
_LARGEST_STANDARD = 0x7FF

_SELF_RECEPTION = 1 << 21
_FORMAT = _EXTENDED | _REMOTE | _SELF_RECEPTION | 0xF << _DLC_SHIFT | _ESI | _FAST_DATA_RATE | _FD


def record_of(message: can.Message, *, fd: bool = True) -> bytes:
    """The message as a record to send; raises BadFrame if no bus could carry it, or none without `fd`.

    As with SocketCAN its dlc is its length: data is cut off or filled with zeros, for FD to the next possible length.
    """
    try:
        identifier, length = message.arbitration_id, message.dlc
    except AttributeError:
        raise TypeError(
            f"msg {message!r}: must be can.Message, not {type(message).__name__}; "
            "can.Message(arbitration_id=0x123, data=[0x11], is_extended_id=False)"
        ) from None
    info = 0
    if message.is_extended_id:
        info = _EXTENDED
        if not 0 <= identifier <= _IDENTIFIER:
            raise BadFrame(f"identifier {identifier:#x}: 29 bits at most")
    elif not 0 <= identifier <= _LARGEST_STANDARD:
        raise BadFrame(f"identifier {identifier:#x}: 11 bits at most; 29 with is_extended_id=True")
    if message.is_fd or message.is_error_frame or length > 8 or length < 0:
        return _unusual(message, info, fd)
    if message.is_remote_frame:
        return _RECORD.pack(0, identifier, info | _REMOTE | length << _DLC_SHIFT, b"")
    return _RECORD.pack(0, identifier, info | length << _DLC_SHIFT, message.data[:length])


def _unusual(message: can.Message, info: int, fd: bool) -> bytes:
    length, data = message.dlc, bytes(message.data)
    if message.is_error_frame:
        raise BadFrame("an error frame cannot be sent: controllers make them by themselves")
    if message.is_fd:
        if not fd:
            raise BadFrame("an FD message on a bus that was opened without fd=True")
        if message.is_remote_frame:
            raise BadFrame("a remote frame is never FD: CAN FD has none")
        if not 0 <= length <= 64:
            raise BadFrame(f"dlc {length}: an FD frame carries 0 to 64 bytes")
        code = length_to_dlc(length)
        info |= _FD
        info |= _FAST_DATA_RATE if message.bitrate_switch else 0
        info |= _ESI if message.error_state_indicator else 0
    else:
        if not 0 <= length <= 15:
            raise BadFrame(f"dlc {length}: a classic frame carries 0 to 8 bytes, with a DLC of 15 at most")
        if message.is_remote_frame:
            info |= _REMOTE
            data = b""
        code, length = length, min(length, 8)
    return _RECORD.pack(0, message.arbitration_id, info | code << _DLC_SHIFT, data[:length])


def take_messages(
    block: memoryview,
    epoch_ns: int,
    channel: Any,
    append: Callable[[can.Message], object],
    tell: Callable[[BusEvent], object],
    *,
    errors: bool,
) -> None:
    """Append the message of each record in the block. If frames were lost before a record, append an error frame first.

    `tell` is called for each change of the controller's state. Without `errors` no error frames are appended.
    """
    message_class = can.Message
    new = message_class.__new__
    for time_ns, identifier, info, data in _RECORD.iter_unpack(block):
        if info & (_TYPE | _OVERRUN):
            if info & _TYPE:
                event = BusEvent.from_record(_RECORD.pack(time_ns, identifier, info, data))
                if event.kind is EventKind.STATE:
                    tell(event)
                if errors:
                    append(_error_message(event, epoch_ns, channel))
                continue
            if errors:
                append(_error_message(BusEvent(EventKind.OVERRUN, time_ns), epoch_ns, channel))
        length, dlc, remote, fd, is_rx, extended, fast, esi = _format(info & _FORMAT)
        message = new(message_class)  # its constructor takes as long as all the rest
        message.timestamp = (epoch_ns + time_ns) / 1e9
        message.arbitration_id = identifier
        message.is_extended_id = extended
        message.is_remote_frame = remote
        message.is_error_frame = False
        message.channel = channel
        message.dlc = dlc
        message.data = bytearray(data[:length])
        message.is_fd = fd
        message.is_rx = is_rx
        message.bitrate_switch = fast
        message.error_state_indicator = esi
        append(message)


@cache
def _format(info: int) -> tuple[int, int, bool, bool, bool, bool, bool, bool]:
    """What the _FORMAT bits of an info word say: bytes of data, dlc, remote, fd, is_rx, extended, BRS, ESI.

    Working it out for each message would take a fifth of its time.
    """
    code, fd, remote = info >> _DLC_SHIFT & 15, info & _FD != 0, info & _REMOTE != 0
    length = 0 if remote else dlc_to_length(code, fd=fd)
    dlc = dlc_to_length(code, fd=True) if fd and not remote else code
    is_rx, extended = info & _SELF_RECEPTION == 0, info & _EXTENDED != 0
    return length, dlc, remote, fd, is_rx, extended, info & _FAST_DATA_RATE != 0, info & _ESI != 0


def _error_message(event: BusEvent, epoch_ns: int, channel: Any) -> can.Message:
    """As python-can's socketcan shows an error frame: its classes are the identifier."""
    classes, data = encode_error_frame(event)
    return can.Message(
        timestamp=(epoch_ns + event.timestamp_ns) / 1e9,
        arbitration_id=classes & _IDENTIFIER,
        is_extended_id=False,
        is_error_frame=True,
        channel=channel,
        dlc=8,
        data=data,
    )
