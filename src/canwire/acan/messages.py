"""Conversion between ACAN's messages and canwire's frames. Source: INduCAN104 manual, "ACAN messages"."""

from __future__ import annotations

from canwire import BadValue, Frame
from canwire.acan.constants import Format
from canwire.acan.identifiers import acan_word, plain_identifier
from canwire.acan.structures import ACANMB

_LONGEST = 8


def message_of(frame: Frame) -> ACANMB:
    """The ACANMB of a received frame. A remote frame has the requested length; length codes above 8 become 8."""
    format = (Format.EXTENDED if frame.extended else 0) | (Format.RTR if frame.remote else 0)
    length = min(frame.dlc, _LONGEST)
    return ACANMB(acan_word(frame.id, frame.extended), int(format), length, frame.data)


def frame_of(message: ACANMB) -> Frame:
    """The frame to send for an ACANMB. Identifier bits without a meaning are ignored; BadValue above 8 bytes."""
    extended = bool(message.bFormat & Format.EXTENDED)
    if message.bLength > _LONGEST:
        raise BadValue(f"bLength {message.bLength}: a message has 0 to {_LONGEST} bytes")
    id = plain_identifier(message.dwID, extended)
    if message.bFormat & Format.RTR:
        return Frame(id, extended=extended, remote=True, dlc=message.bLength)
    return Frame(id, message.bData[: message.bLength], extended=extended)
