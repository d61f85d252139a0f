"""Reports in the error queue of a socket about messages in transit.

Source: linux/can/j1939.h, linux/errqueue.h, Linux' Documentation/networking/j1939.rst.
"""

from __future__ import annotations

import errno
import struct
from enum import Enum
from typing import NamedTuple

from canwire.socketcan.j1939.message import Message

_BYTES_ACKED, _TOTAL_SIZE, _PGN, _SOURCE_NAME, _DESTINATION_NAME, _SOURCE, _DESTINATION = range(1, 8)
_ERROR = struct.Struct("<IBBBBII")  # struct sock_extended_err
_LOCAL, _TIMESTAMPING = 1, 4  # SO_EE_ORIGIN_
_ATTRIBUTE = struct.Struct("<HH")
TX_SCHEDULED, RX_SOFTWARE, OPTION_ID, TX_ACKNOWLEDGED = 1 << 8, 1 << 3, 1 << 7, 1 << 9  # SOF_TIMESTAMPING_


class What(Enum):
    """The kind of a report; its value is ee_origin, ee_info, and the required flag of SO_TIMESTAMPING, 0: none."""

    ACKNOWLEDGED = (_TIMESTAMPING, 2, TX_ACKNOWLEDGED)
    SCHEDULED = (_TIMESTAMPING, 1, TX_SCHEDULED)
    ABORTED = (_LOCAL, 1, 0)
    ANNOUNCED = (_LOCAL, 2, RX_SOFTWARE)  # an RTS or BAM has come
    OFFSET = (_LOCAL, 3, RX_SOFTWARE)  # ETP's DPO
    LOST = (_LOCAL, 4, RX_SOFTWARE)  # a message that was being received


class Report(NamedTuple):
    """`done` bytes of the message have arrived; `number` counts messages of a socket, or those received on a bus."""

    what: What
    number: int
    message: Message
    size: int
    done: int
    error: int = errno.ENOMSG

    def extended_error(self, flags: int) -> bytes:
        """struct sock_extended_err, with SO_TIMESTAMPING set to these flags."""
        origin, info, _ = self.what.value
        return _ERROR.pack(self.error, origin, 0, 0, 0, info, self.number if flags & OPTION_ID else 0)

    def statistics(self) -> bytes:
        """Netlink attributes J1939_NLA_*."""
        if self.what is not What.ANNOUNCED:
            return _attribute(_BYTES_ACKED, struct.pack("<I", self.done))
        message = self.message
        return b"".join(
            (
                _attribute(_TOTAL_SIZE, struct.pack("<I", self.size)),
                _attribute(_PGN, struct.pack("<I", message.pgn)),
                _attribute(_SOURCE_NAME, struct.pack("<Q", message.source_name)),
                _attribute(_DESTINATION_NAME, struct.pack("<Q", message.destination_name)),
                _attribute(_SOURCE, bytes((message.source,))),
                _attribute(_DESTINATION, bytes((message.destination,))),
            )
        )


def _attribute(kind: int, value: bytes) -> bytes:
    return _ATTRIBUTE.pack(_ATTRIBUTE.size + len(value), kind) + value + bytes(-len(value) % 4)
