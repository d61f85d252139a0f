"""The error queue of a J1939 socket: what it says of each message, as recvmsg(MSG_ERRQUEUE) hands it over."""

from __future__ import annotations

import struct
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from canwire.socketcan.constants import SOL_CAN_J1939

if TYPE_CHECKING:
    from canwire.socketcan.j1939.reports import Report
    from canwire.socketcan.table import Stamps

_SOL_SOCKET, _STATISTICS, _ERROR_QUEUE = 1, 54, 4  # SCM_TIMESTAMPING_OPT_STATS, SCM_J1939_ERRQUEUE
_SOFTWARE = 1 << 4  # SOF_TIMESTAMPING_SOFTWARE
_CMSG = struct.Struct("<Qii")
_MOST = 1024


class Queued(NamedTuple):
    """The data, and the control messages, as they are in a program's memory."""

    data: bytes
    control: bytes


class ErrorQueue:
    """Of one socket, while SO_J1939_ERRQUEUE is set."""

    def __init__(self) -> None:
        self._entries: deque[Queued] = deque()

    def __len__(self) -> int:
        return len(self._entries)

    def put(self, report: Report, stamps: Stamps, stamp_ns: int) -> bool:
        """Keep it, if SO_TIMESTAMPING asks for such; whether it was."""
        needed = report.what.value[2]
        if (needed and not stamps.flags & needed) or len(self._entries) >= _MOST:
            return False
        statistics = report.statistics()
        control = b""
        if stamps.flags & _SOFTWARE:
            time = struct.pack("<qq32x", *divmod(stamp_ns, 1_000_000_000))
            control += control_message(_SOL_SOCKET, stamps.stamping, time)
            control += control_message(_SOL_SOCKET, _STATISTICS, statistics)
        control += control_message(SOL_CAN_J1939, _ERROR_QUEUE, report.extended_error(stamps.flags))
        self._entries.append(Queued(statistics, control))
        return True

    def take(self) -> Queued | None:
        """The oldest."""
        return self._entries.popleft() if self._entries else None

    def clear(self) -> None:
        self._entries.clear()


def control_message(level: int, kind: int, data: bytes) -> bytes:
    """struct cmsghdr, its data, and what fills it up."""
    length = _CMSG.size + len(data)
    return _CMSG.pack(length, level, kind) + data + bytes(-length % 8)
