"""ILinMonitor: the receive queue of one program on a LIN line.

Source: VCI V4 manual 5.3.2 and 6.7.3; rulings.md 7 and 12.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Self
from uuid import UUID

from canwire import LinMonitorMode
from canwire.vci.arguments import UINT16, within
from canwire.vci.bus_line import BusLine
from canwire.vci.fifo.elements import LIN_MSGS
from canwire.vci.fifo.size import whole_pages
from canwire.vci.lin.constants import (
    LIN_MSGTYPE_ERROR,
    LIN_MSGTYPE_INFO,
    LIN_MSGTYPE_SLEEP,
    LIN_MSGTYPE_STATUS,
    LIN_MSGTYPE_TMOVR,
)
from canwire.vci.lin.line import line_status
from canwire.vci.lin.message import LinMsg
from canwire.vci.lin.structures import LinMonitorStatus
from canwire.vci.line_objects import QueueObject
from canwire.vci.structures.guids import IID_ILinMonitor, IID_IUnknown
from canwire.vci.unknown import vci_call

if TYPE_CHECKING:
    import canwire

# LIN_MSGTYPE_WAKEUP is only for sending (manual 7.4.5)
_EVENTS = (LIN_MSGTYPE_INFO, LIN_MSGTYPE_ERROR, LIN_MSGTYPE_STATUS, LIN_MSGTYPE_SLEEP, LIN_MSGTYPE_TMOVR)


class LinMonitor(QueueObject[LinMsg]):
    """ILinMonitor: the messages that the line receives, with its own responses (LinMsg). Source: manual 6.7.3."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ILinMonitor})

    _lease: canwire.Monitor
    _form = LIN_MSGS

    @classmethod
    def open(cls, line: BusLine, *, exclusive: bool) -> Self:
        """Open a monitor; the socket calls this."""
        lease = line.open_monitor(exclusive=exclusive)
        return cls(line.share(), lease)

    @vci_call
    def initialize(self, rx_size: int) -> None:
        """Initialize: make the FIFO, for at least `rx_size` messages; the monitor is inactive afterwards.

        `rx_size`, 1 to 65535, is rounded up to whole pages of memory. A further call makes a new FIFO: the old messages
        are lost, and the old reader can no longer be used. Raises VciInvalidArgument.
        """
        capacity = whole_pages(within("rx_size", rx_size, 1, UINT16), LinMsg.SIZE)
        self._lease.set_up(LinMonitorMode(receive=capacity, exact=True, ticks=True, events=_EVENTS))
        self._made_anew()

    @vci_call
    def get_status(self) -> LinMonitorStatus:
        """GetStatus: state of monitor and line, at any time; `rx_overrun` stays until `initialize`."""
        return LinMonitorStatus(line_status(self._line.lin_status()), *self._state())
