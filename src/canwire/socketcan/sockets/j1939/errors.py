"""The error queue of a J1939 socket: reports about each message, as recvmsg(MSG_ERRQUEUE) reads them."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from canwire.socketcan.constants import SOL_CAN_J1939
from canwire.socketcan.sockets.error_queue import SOL_SOCKET, ErrorQueue, Queued, control_message

if TYPE_CHECKING:
    from canwire.socketcan.j1939.reports import Report
    from canwire.socketcan.table import Stamps

_STATISTICS, _ERROR_QUEUE = 54, 4  # SCM_TIMESTAMPING_OPT_STATS, SCM_J1939_ERRQUEUE
_SOFTWARE = 1 << 4  # SOF_TIMESTAMPING_SOFTWARE


class Reports(ErrorQueue):
    """The reports of one socket, while SO_J1939_ERRQUEUE is set."""

    def put(self, report: Report, stamps: Stamps, stamp_ns: int) -> bool:
        """Keep a report if SO_TIMESTAMPING requests its kind; returns whether it was kept."""
        needed = report.what.value[2]
        if needed and not stamps.flags & needed:
            return False
        statistics = report.statistics()
        control = b""
        if stamps.flags & _SOFTWARE:
            time = struct.pack("<qq32x", *divmod(stamp_ns, 1_000_000_000))
            control += control_message(SOL_SOCKET, stamps.stamping, time)
            control += control_message(SOL_SOCKET, _STATISTICS, statistics)
        control += control_message(SOL_CAN_J1939, _ERROR_QUEUE, report.extended_error(stamps.flags))
        return self.keep(Queued(statistics, control))
