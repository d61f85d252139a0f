"""One connector of a board, and the access layer, which each of its interfaces keeps open.

Source: VCI V4 manual chapter 5.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Self

from canwire import NoSuchBoard, Unsupported
from canwire.vci.controller_types import VCI_BUS_CAN, VCI_BUS_LIN, VCI_BUS_RES, vci_bus_ctrl
from canwire.vci.structures.errors import VCI_E_DEVICE_NOT_CONNECTED
from canwire.vci.translation import meaning

if TYPE_CHECKING:
    from canwire import (
        BoardInfo,
        Capabilities,
        Control,
        Hub,
        HubChannel,
        Lease,
        LinCapabilities,
        LinControl,
        LineInfo,
        LineStatus,
        LinLineStatus,
        Monitor,
        Scheduler,
    )

_BUSES = {"can": VCI_BUS_CAN, "lin": VCI_BUS_LIN}

KIN = "VCI"  # VCI programs may configure a line that another VCI program runs, as in the manual, and receive the same


class Layer:
    """The open bus access layer of a board: while any share of it is open, no other layer can be opened."""

    def __init__(self, lease: Lease) -> None:
        self._lease = lease
        self._shares = 1

    def check(self) -> None:
        """Raises Unplugged, HubLost or Closed if the layer can no longer be used."""
        self._lease.check()

    def share(self) -> Self:
        self._shares += 1
        return self

    def close(self) -> None:
        """Close one share; the last one closes the layer."""
        self._shares -= 1
        if self._shares == 0:
            self._lease.close()


class BusLine:
    """Connector `number` (from 0) of a board, with a share of its access layer."""

    def __init__(self, hub: Hub, board: BoardInfo, number: int, layer: Layer) -> None:
        self.hub = hub
        self.board = board
        self.number = number
        self.layer = layer

    @property
    def info(self) -> LineInfo:
        return self.board.lines[self.number]

    @property
    def capabilities(self) -> Capabilities:
        return self.info.capabilities

    @property
    def lin_capabilities(self) -> LinCapabilities:
        """The capabilities of a LIN line; raises Unsupported for another line."""
        if self.info.lin is None:
            raise Unsupported(f"{self.info.name} is not a LIN line")
        return self.info.lin

    def status(self) -> LineStatus:
        with self._plugged():
            return self.hub.line_status(self.board.id, self.number, kin=KIN)

    def obstacle(self) -> str:
        """The obstacle that keeps a real adapter off its bus; "" if there is none."""
        return self.hub.obstacle(self.board, self.number)

    def open_control(self) -> Control:
        with self._plugged():
            return self.hub.open_control(self.board.id, self.number, kin=KIN)

    def open_channel(self, *, exclusive: bool) -> HubChannel:
        with self._plugged():
            return self.hub.open_channel(self.board.id, self.number, exclusive=exclusive)

    def open_scheduler(self) -> Scheduler:
        with self._plugged():
            return self.hub.open_scheduler(self.board.id, self.number, kin=KIN)

    def keep_settings(self) -> Lease:
        with self._plugged():
            return self.hub.keep_settings(self.board.id, self.number)

    def lin_status(self) -> LinLineStatus:
        with self._plugged():
            return self.hub.lin_status(self.board.id, self.number).status

    def open_lin_control(self) -> LinControl:
        with self._plugged():
            return self.hub.open_lin_control(self.board.id, self.number)

    def open_monitor(self, *, exclusive: bool) -> Monitor:
        with self._plugged():
            return self.hub.open_monitor(self.board.id, self.number, exclusive=exclusive)

    def share(self) -> BusLine:
        """The same connector, with a separate share of the access layer."""
        return BusLine(self.hub, self.board, self.number, self.layer.share())

    @staticmethod
    def _plugged() -> AbstractContextManager[None]:
        """A context in which a board that the hub no longer has raises VCI_E_DEVICE_NOT_CONNECTED: it was removed."""
        return meaning(VCI_E_DEVICE_NOT_CONNECTED, NoSuchBoard)


def bus_of(line: LineInfo) -> int:
    """VCI_BUS_ of a connector."""
    return _BUSES.get(line.bus_type.lower(), VCI_BUS_RES)


def bus_ctrl_of(line: LineInfo) -> int:
    """Bus and controller of a connector as one word (controller_types.py)."""
    capabilities = line.lin or line.capabilities
    return vci_bus_ctrl(bus_of(line), capabilities.controller_type)
