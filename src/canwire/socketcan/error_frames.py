"""The hub's events as the error frames of linux/can/error.h, with the chip's own place of an error where it has one."""

from __future__ import annotations

from canwire import BusEvent, ErrorKind, EventKind, encode_error_frame

_TYPE_AT, _PLACE_AT = 2, 3
_BIT, _TX = 0x01, 0x80
_SEGMENT, _RECEIVING = 0x1F, 0x20  # of SJA1000's error code capture: where, and whether as a receiver
# the segments of the error code capture are the kernel's CAN_ERR_PROT_LOC_ (SJA1000 data sheet, table 20)


def error_frame_of(event: BusEvent) -> tuple[int, bytes]:
    """(identifier word, 8 bytes)."""
    id, data = encode_error_frame(event)
    if event.kind is EventKind.ERROR and event.code and event.error is not ErrorKind.ACK:
        exact = bytearray(data)
        exact[_PLACE_AT] = event.code & _SEGMENT
        return id, bytes(exact)
    return id, data
