"""ILinSocket: the capabilities and the status of a LIN line, and monitors on it.

Source: VCI V4 manual 5.3.1, 6.7.1 and 7.4.1.
"""

from __future__ import annotations

from typing import ClassVar
from uuid import UUID

from canwire.vci.lin.line import capabilities_of, line_status
from canwire.vci.lin.monitor import LinMonitor
from canwire.vci.lin.structures import LinCapabilities, LinLineStatus
from canwire.vci.line_objects import SocketObject
from canwire.vci.structures.guids import IID_ILinSocket, IID_IUnknown
from canwire.vci.unknown import vci_call


class LinSocket(SocketObject):
    """ILinSocket: properties and state of a line, and monitors. Source: manual 6.7.1."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ILinSocket})

    @vci_call
    def get_capabilities(self) -> LinCapabilities:
        """GetCapabilities: LIN_FEATURE_ and the counter of the time stamps."""
        return capabilities_of(self._line.lin_capabilities)

    @vci_call
    def get_line_status(self) -> LinLineStatus:
        """GetLineStatus: settings, load and state of the controller now."""
        return line_status(self._line.lin_status())

    @vci_call
    def create_monitor(self, exclusive: bool = False) -> LinMonitor:
        """CreateMonitor: a new monitor, which is not initialised yet.

        An exclusive monitor must be the only one of the line: raises VciAccessDenied if another monitor is open, or if
        an exclusive monitor is open.
        """
        return LinMonitor.open(self._line, exclusive=bool(exclusive))
