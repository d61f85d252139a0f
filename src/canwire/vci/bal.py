"""IBalObject: the bus access layer of a board, from which its connectors are opened.

Source: VCI V4 manual 5.1 and 6.5.1; reference/vci.md section 7a.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Self
from uuid import UUID

from canwire.vci.bus_line import BusLine, Layer, bus_ctrl_of, bus_of
from canwire.vci.can.control import CanControl, CanControl2
from canwire.vci.can.scheduler import CanScheduler, CanScheduler2
from canwire.vci.can.socket import CanSocket, CanSocket2
from canwire.vci.controller_types import VCI_BUS_CAN, VCI_BUS_LIN
from canwire.vci.lin.control import LinControl
from canwire.vci.lin.socket import LinSocket
from canwire.vci.line_objects import LeaseObject
from canwire.vci.structures.devices import BalFeatures
from canwire.vci.structures.errors import VCI_E_INVALID_INDEX, VCI_E_NOT_IMPLEMENTED, VciError
from canwire.vci.structures.guids import (
    INTERFACES,
    IID_IBalObject,
    IID_ICanControl,
    IID_ICanControl2,
    IID_ICanScheduler,
    IID_ICanScheduler2,
    IID_ICanSocket,
    IID_ICanSocket2,
    IID_ILinControl,
    IID_ILinSocket,
    IID_IUnknown,
)
from canwire.vci.unknown import Unknown, interface_name, no_interface, vci_call

if TYPE_CHECKING:
    from canwire import BoardInfo, Hub

LAYER = "bal"
_INTERFACES: Mapping[UUID, tuple[int, Callable[[BusLine], Unknown]]] = {
    IID_ICanSocket: (VCI_BUS_CAN, CanSocket.open),
    IID_ICanSocket2: (VCI_BUS_CAN, CanSocket2.open),
    IID_ICanControl: (VCI_BUS_CAN, CanControl.open),
    IID_ICanControl2: (VCI_BUS_CAN, CanControl2.open),
    IID_ICanScheduler: (VCI_BUS_CAN, CanScheduler.open),
    IID_ICanScheduler2: (VCI_BUS_CAN, CanScheduler2.open),
    IID_ILinSocket: (VCI_BUS_LIN, LinSocket.open),
    IID_ILinControl: (VCI_BUS_LIN, LinControl.open),
}
_BUS_INTERFACES = {iid for name, iid in INTERFACES.items() if name.startswith(("ICan", "ILin"))}


class BalObject(Unknown):
    """IBalObject. Any number of programs may open it, unless another access layer of the board is open.

    It stays open while any interface that was opened from it is open. Source: manual 6.5.1.
    """

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_IBalObject})

    def __init__(self, hub: Hub, board: BoardInfo, layer: Layer) -> None:
        super().__init__()
        self._hub = hub
        self._board = board
        self._layer = layer

    @classmethod
    def open(cls, hub: Hub, board: BoardInfo) -> Self:
        """Open the access layer of a board; VciDevice calls this."""
        return cls(hub, board, Layer(hub.open_layer(board.id, LAYER)))

    @vci_call
    def get_features(self) -> BalFeatures:
        """GetFeatures: version of the firmware, number and types of the connectors."""
        major, minor = self._board.firmware_version
        types = [bus_ctrl_of(line) for line in self._board.lines]
        return BalFeatures(major, minor, len(types), types)

    @vci_call
    def open_socket(self, bus_no: int, iid: UUID) -> Any:
        """OpenSocket: an interface of connector `bus_no`, 0 to bus_socket_count - 1.

        A CAN connector has IID_ICanSocket, IID_ICanControl and IID_ICanScheduler, each with or without a 2 at its
        end; a LIN connector has IID_ILinSocket and IID_ILinControl. Sockets create channels and monitors. Raises
        VciInvalidIndex for another number, VciAccessDenied for a control or scheduler that is open already,
        VciNotImplemented for an interface that this connector does not have, VciNoInterface for any other.
        """
        if not isinstance(bus_no, int) or not 0 <= bus_no < len(self._board.lines):
            last = len(self._board.lines) - 1
            raise VciError.of(VCI_E_INVALID_INDEX, f"connector {bus_no!r}: this board has 0 to {last}")
        if iid not in _BUS_INTERFACES:
            raise no_interface(self, iid)
        line = self._board.lines[bus_no]
        bus, opened = _INTERFACES.get(iid, (None, None))
        if opened is None or bus_of(line) != bus:
            raise VciError.of(VCI_E_NOT_IMPLEMENTED, f"{line.name} has no {interface_name(iid)}")
        return opened(BusLine(self._hub, self._board, bus_no, self._layer))

    def keep_settings(self, bus_no: int) -> LeaseObject:
        """For V3, in which a line keeps its settings while any of its interfaces is open (rulings.md 37)."""
        line = BusLine(self._hub, self._board, bus_no, self._layer)
        lease = line.keep_settings()
        return LeaseObject(line.share(), lease)

    def _check(self) -> None:
        super()._check()
        self._layer.check()

    def _close(self) -> None:
        self._layer.close()
