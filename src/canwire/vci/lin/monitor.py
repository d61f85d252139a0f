"""ILinMonitor: a program's own receive queue on a LIN line.

Source: VCI V4 manual (seed 004) 5.3.2 and 6.7.3; rulings.md 7 and 12.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Self
from uuid import UUID

from canwire import LinMonitorMode
from canwire.vci.arguments import UINT16, within
from canwire.vci.bus_line import BusLine, LineObject
from canwire.vci.fifo.elements import LIN_MSGS
from canwire.vci.fifo.fifo import FifoReader
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
from canwire.vci.structures.errors import VCI_E_ACCESSDENIED, VCI_E_NOT_INITIALIZED, VciError
from canwire.vci.structures.guids import IID_ILinMonitor, IID_IUnknown
from canwire.vci.unknown import vci_call

if TYPE_CHECKING:
    import canwire

# LIN_MSGTYPE_WAKEUP is for sending alone (manual 7.4.5)
_EVENTS = (LIN_MSGTYPE_INFO, LIN_MSGTYPE_ERROR, LIN_MSGTYPE_STATUS, LIN_MSGTYPE_SLEEP, LIN_MSGTYPE_TMOVR)


class LinMonitor(LineObject):
    """ILinMonitor: what the line hears, its own responses among it (LinMsg). It sends nothing. Source: manual 6.7.3."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ILinMonitor})

    def __init__(self, line: BusLine, lease: canwire.Monitor) -> None:
        super().__init__(line)
        self._lease = lease
        self._initialized = False
        self._reader: FifoReader[LinMsg] | None = None

    @classmethod
    def open(cls, line: BusLine, *, exclusive: bool) -> Self:
        """For the socket."""
        lease = line.open_monitor(exclusive=exclusive)
        return cls(line.share(), lease)

    @vci_call
    def initialize(self, rx_size: int) -> None:
        """Initialize: make the FIFO, for at least so many messages; the monitor is inactive then.

        `rx_size` 1 to 65535 grows to whole pages of memory. May be repeated: what stood in the FIFO is gone then,
        and its reader is dead. Raises VciInvalidArgument.
        """
        capacity = whole_pages(within("rx_size", rx_size, 1, UINT16), LinMsg.SIZE)
        self._lease.set_up(LinMonitorMode(receive=capacity, exact=True, ticks=True, events=_EVENTS))
        self._cut(f"{self._lease.name} was initialised anew")
        self._initialized = True

    @vci_call
    def activate(self) -> None:
        """Activate: from now on messages come, as far as the line runs. Raises VciNotInitialized."""
        self._check_initialized()
        self._lease.activate()

    @vci_call
    def deactivate(self) -> None:
        """Deactivate: no more; what waits in the FIFO stays. Raises VciNotInitialized."""
        self._check_initialized()
        self._lease.deactivate()

    @vci_call
    def get_reader(self) -> FifoReader[LinMsg]:
        """GetReader: the reading end of the FIFO.

        Raises VciNotInitialized before `initialize`, VciAccessDenied while it is open.
        """
        self._check_initialized()
        if self._reader is not None:
            raise VciError.of(VCI_E_ACCESSDENIED, f"{self._lease.name}: its reader is open; release it first")
        self._reader = FifoReader(self._lease.reading, LIN_MSGS, self._given_back)
        return self._reader

    @vci_call
    def get_status(self) -> LinMonitorStatus:
        """GetStatus: state of monitor and line, at any time; `rx_overrun` stays until `initialize`."""
        made = LinMonitorStatus(line_status(self._line.lin_status()))
        if self._initialized:
            status, ring = self._lease.status(), self._lease.reading.ring
            made.activated, made.rx_overrun = status.active, status.lost > 0
            made.rx_fifo_load = ring.fill() * 100 // ring.capacity
        return made

    def _check(self) -> None:
        super()._check()
        self._lease.check()

    def _check_initialized(self) -> None:
        if not self._initialized:
            raise VciError.of(VCI_E_NOT_INITIALIZED, f"{self._lease.name}: call initialize first")

    def _given_back(self) -> None:
        self._reader = None

    def _cut(self, why: str) -> None:
        if self._reader is not None:
            self._reader.cut(why)
            self._reader = None

    def _close(self) -> None:
        self._cut(f"{self._lease.name} was released")
        try:
            self._lease.close()
        finally:
            super()._close()
