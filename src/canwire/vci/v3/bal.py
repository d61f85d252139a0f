"""IBalObject: the bus access layer of a board.

Source: VCI V3 .NET manual 4.1; reference/vci.md section 7a.
"""

from __future__ import annotations

from typing import TypeVar

from canwire.vci import bal
from canwire.vci.structures.errors import VCI_E_NOT_IMPLEMENTED
from canwire.vci.v3.bus_socket import BusSocket
from canwire.vci.v3.device_info import Version
from canwire.vci.v3.disposable import Disposable, net_call
from canwire.vci.v3.errors import NotImplementedException
from canwire.vci.v3.resource import BalResourceCollection, resources_of

Socket = TypeVar("Socket", bound=BusSocket)


class BalObject(Disposable):
    """IBalObject. Any number of programs may open it; interfaces opened from it stay open after its `dispose`."""

    def __init__(self, access_layer: bal.BalObject) -> None:
        """For IVciDevice.OpenBusAccessLayer."""
        super().__init__()
        self._bal = self._hold(access_layer)

    @property
    @net_call
    def firmware_version(self) -> Version:
        """FirmwareVersion: major and minor."""
        features = self._bal.get_features()
        return Version(features.fw_major_version, features.fw_minor_version)

    @property
    @net_call
    def resources(self) -> BalResourceCollection:
        """Resources: the connectors."""
        features = self._bal.get_features()
        return resources_of(features.bus_socket_type[: features.bus_socket_count])

    @net_call
    def open_socket(self, bus_port: int, socket_type: type[Socket]) -> Socket:
        """OpenSocket: an interface of connector `bus_port`, 0 to Resources.Count - 1.

        `socket_type` is CanSocket, CanChannel, CanControl or CanScheduler for a CAN connector, LinSocket, LinMonitor or
        LinControl for a LIN connector. Raises ArgumentOutOfRangeException; VciException for a control unit or cyclic
        list that a program has, and while an exclusive channel or monitor is open; NotImplementedException for an
        interface that the connector does not have.
        """
        place = self.resources[bus_port]
        if not (isinstance(socket_type, type) and issubclass(socket_type, BusSocket)):
            raise NotImplementedException(
                VCI_E_NOT_IMPLEMENTED,
                f"{place.bus_name} has no {getattr(socket_type, '__name__', socket_type)}",
            )
        return socket_type(self._bal, place)
