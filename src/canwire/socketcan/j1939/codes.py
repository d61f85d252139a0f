"""Commands and abort reasons of J1939's transport protocol, and the errors that a program gets for the reasons.

Source: SAE J1939-21 5.10 (TP), ISO 11783-3 5.11 (ETP); the errno's are those of Linux' documentation.
"""

from __future__ import annotations

import errno
from enum import IntEnum
from typing import NamedTuple

PACKET = 7  # bytes of a message in one data frame
LARGEST_TP = 255 * PACKET
LARGEST_ETP = 0xFFFFFF * PACKET
SMALLEST_TP = 9
MOST_IN_BLOCK = 255
ABORT = 0xFF
BAM = 0x20
PAD = 0xFF


class Kind(NamedTuple):
    """The two forms of the protocol: their PGNs and commands."""

    control: int
    data: int
    rts: int
    cts: int
    eom: int
    extended: bool


TP = Kind(0xEC00, 0xEB00, 0x10, 0x11, 0x13, False)
ETP = Kind(0xC800, 0xC700, 0x14, 0x15, 0x17, True)
DPO = 0x16  # of ETP alone: where the next packets begin
KINDS = (TP, ETP)
RESERVED = tuple(pgn for kind in KINDS for pgn in (kind.control, kind.data))  # no program sends these itself


class Abort(IntEnum):
    """Why a connection ends."""

    BUSY = 1
    RESOURCE = 2
    TIMEOUT = 3
    GENERIC = 4
    FAULT = 5
    UNEXPECTED_DATA = 6
    BAD_SEQUENCE = 7
    DUPLICATE = 8
    BAD_DPO_PGN = 10
    BAD_CTS_PGN = 14
    CTS_TOO_BIG = 15
    OTHER = 250


ERRORS = {
    Abort.BUSY: errno.EALREADY,
    Abort.RESOURCE: errno.EMSGSIZE,
    Abort.TIMEOUT: errno.EHOSTUNREACH,
    Abort.GENERIC: errno.EBADMSG,
    Abort.FAULT: errno.ENOTRECOVERABLE,
    Abort.UNEXPECTED_DATA: errno.ENOTCONN,
    Abort.BAD_SEQUENCE: errno.EILSEQ,
}  # all others: EPROTO


def error_of(reason: int) -> int:
    """The errno of an abort reason, known or not."""
    return next((error for abort, error in ERRORS.items() if abort == reason), errno.EPROTO)


def packets(size: int) -> int:
    """The number of data frames for this many bytes."""
    return -(-size // PACKET)
