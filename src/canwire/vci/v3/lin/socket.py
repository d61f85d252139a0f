"""ILinSocket: the capabilities and the status of a LIN line; the base of monitors and control units.

Source: VCI V3 .NET manual 4.3.2; reference/vci.md section 7a.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar
from uuid import UUID

from canwire.vci.structures.guids import IID_ILinSocket
from canwire.vci.v3.bus_socket import BusSocket
from canwire.vci.v3.disposable import net_call
from canwire.vci.v3.lin.enums import LinFeatures
from canwire.vci.v3.lin.status import LinLineStatus

if TYPE_CHECKING:
    from canwire.vci.lin import socket as lin_socket
    from canwire.vci.lin import structures as lin_structures


class LinSocket(BusSocket):
    """ILinSocket. Any number of programs may have one; it cannot change the line.

    A tick of a time stamp lasts `time_stamp_counter_divisor` / `clock_frequency` seconds.
    """

    _iid: ClassVar[UUID] = IID_ILinSocket
    _socket: lin_socket.LinSocket

    def _capabilities(self) -> lin_structures.LinCapabilities:
        return self._socket.get_capabilities()

    @property
    @net_call
    def line_status(self) -> LinLineStatus:
        """LineStatus: settings, load and state of the controller now."""
        return LinLineStatus.of(self._socket.get_line_status())

    @property
    @net_call
    def features(self) -> LinFeatures:
        """Features."""
        return LinFeatures(self._capabilities().features)

    @property
    def supports_master_mode(self) -> bool:
        """SupportsMasterMode: LinOperatingModes.MASTER."""
        return LinFeatures.MASTER in self.features

    @property
    def supports_autorate(self) -> bool:
        """SupportsAutorate: LinBitrate.AUTO_RATE for a slave."""
        return LinFeatures.AUTORATE in self.features

    @property
    def supports_error_frames(self) -> bool:
        """SupportsErrorFrames: LinOperatingModes.ERRORS."""
        return LinFeatures.ERR_FRAME in self.features

    @property
    def supports_bus_load_computation(self) -> bool:
        """SupportsBusLoadComputation."""
        return LinFeatures.BUSLOAD in self.features
