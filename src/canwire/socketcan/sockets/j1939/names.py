"""struct sockaddr_can with the fields of CAN_J1939.

Source: linux/can.h.
"""

from __future__ import annotations

import errno
import struct
from typing import NamedTuple

from canwire.socketcan.constants import AF_CAN
from canwire.socketcan.j1939.message import LARGEST_PGN, has_destination
from canwire.socketcan.ports import refuse

_ADDRESS = struct.Struct("<HxxiQIBxxx")


class Name(NamedTuple):
    """All fields except the family."""

    interface: int
    name: int
    pgn: int
    address: int

    def pack(self) -> bytes:
        return _ADDRESS.pack(AF_CAN, *self)


def parsed(address: bytes, *, index_needed: bool = True) -> Name:
    """The fields in these bytes; raises OSError."""
    if len(address) < _ADDRESS.size:
        raise refuse(errno.EINVAL)
    family, index, name, pgn, own = _ADDRESS.unpack_from(address)
    if family != AF_CAN:
        raise refuse(errno.EINVAL)
    if index_needed and not index:
        raise refuse(errno.ENODEV)
    if pgn <= LARGEST_PGN and has_destination(pgn) and pgn & 0xFF:
        raise refuse(errno.EINVAL)
    return Name(index, name, pgn, own)
