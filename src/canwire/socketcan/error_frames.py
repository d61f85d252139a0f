"""The hub's events as the error frames of linux/can/error.h, with the chip's own place of an error where it has one.

The counters stand in data[6] and data[7] without CAN_ERR_CNT, as kernels before 6.0 had them: programs made before
that, Debian 12's candump among them, refuse a frame with a class that they do not know.
"""

from __future__ import annotations

from canwire import BusEvent, ErrorKind, EventKind, encode_error_frame

_CAN_ERR_CNT = 0x200
_PLACE_AT = 3
_SEGMENT = 0x1F  # of SJA1000's error code capture: where it was
# the segments of the error code capture are the kernel's CAN_ERR_PROT_LOC_ (SJA1000 data sheet, table 20)


def error_frame_of(event: BusEvent) -> tuple[int, bytes]:
    """(identifier word, 8 bytes)."""
    id, data = encode_error_frame(event)
    id &= ~_CAN_ERR_CNT
    if event.kind is EventKind.ERROR and event.code and event.error is not ErrorKind.ACK:
        exact = bytearray(data)
        exact[_PLACE_AT] = event.code & _SEGMENT
        return id, bytes(exact)
    return id, data
