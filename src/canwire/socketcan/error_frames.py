"""Converts the hub's events to the error frames of linux/can/error.h, with the location that a chip reports, if any.

The counters are in data[6] and data[7] without CAN_ERR_CNT, as in kernels before 6.0: older programs, such as Debian
12's candump, refuse a frame with a class that they do not know.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from canwire import BusEvent, ErrorKind, ErrorState, EventKind, encode_error_frame
from canwire.socketcan.constants import CAN_MTU

_ANY_CLASS = 0x1FF  # an error frame without one of these says something that SocketCAN has no word for
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


def put_error_frame(row: Any, event: BusEvent) -> bool:
    """Write the error frame into a row of `received_dtype`; False if the event has none."""
    can_id, data = error_frame_of(event)
    if not can_id & _ANY_CLASS:
        return False
    row["can_id"], row["length"], row["len"], row["flags"] = can_id, CAN_MTU, len(data), 0
    row["fd_flags"] = row["raw_dlc"] = 0
    row["data"] = 0
    row["data"][: len(data)] = list(data)
    return True


def put_error_frames(records: Any, rows: Any, errors: Any, on_state: Callable[[ErrorState], object]) -> Any:
    """Turn the events among records (`errors` is their mask) into error frames; returns a mask of rows to pass on.

    `on_state` hears each state before the error frame that says it, as a kernel's driver takes the carrier away first.
    The error that leads to bus-off says so, too, and the event of the state may come in a later batch.
    """
    kept = ~errors
    for at in errors.nonzero()[0]:
        event = BusEvent.from_record(records[at].tobytes())
        leads_there = event.kind is EventKind.ERROR and event.state is ErrorState.BUS_OFF
        if event.kind is EventKind.STATE or leads_there:
            on_state(event.state)
        kept[at] = put_error_frame(rows[at], event)
    return kept
