"""Data length codes: the number of bytes for each value of four bits.

Source: ISO 11898-1:2015 8.4.2.4; reference/can-protocol.md sections 1 and 4.
"""

from __future__ import annotations

from canwire.values.checks import whole

FD_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
CLASSIC_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 8, 8, 8, 8, 8, 8, 8)


def dlc_to_length(dlc: int, *, fd: bool) -> int:
    """Number of bytes for a data length code of 0..15; a classic frame never carries more than 8.

    Raises BadValue for any other code.
    """
    return (FD_LENGTHS if fd else CLASSIC_LENGTHS)[whole("dlc", dlc, 0, 15)]


def length_to_dlc(length: int) -> int:
    """The smallest data length code whose CAN FD length is at least `length` (0..64); raises BadValue."""
    wanted = whole("length", length, 0, 64)
    return next(dlc for dlc, bytes_ in enumerate(FD_LENGTHS) if bytes_ >= wanted)
