"""One bus of a hub: the wires that its boards are connected to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.errors import Unsupported
from canwire.hub.handles.bus.can import CanBusFaults
from canwire.hub.handles.bus.lin import LinBusFaults
from canwire.hub.protocol import messages as m
from canwire.values.mistakes.names import answers_wrong_names

if TYPE_CHECKING:
    from canwire.hub.handles.client import Client


@answers_wrong_names
class HubBus:
    """A CAN bus; `faults` sets and lists its faults. `Hub.bus` returns it."""

    def __init__(self, hub: Client, name: str) -> None:
        if hub.call(m.GetBus(name)).kind != "CAN":
            raise Unsupported(f"{name} is a LIN bus: `lin_bus` gives it")
        self.name = name
        self.faults = CanBusFaults(hub, name)

    def __repr__(self) -> str:
        return f"<CAN bus {self.name}>"


class HubLinBus:
    """A LIN bus; `faults` sets and lists its faults. `Hub.lin_bus` returns it."""

    def __init__(self, hub: Client, name: str) -> None:
        if hub.call(m.GetBus(name)).kind != "LIN":
            raise Unsupported(f"{name} is a CAN bus: `bus` gives it")
        self.name = name
        self.faults = LinBusFaults(hub, name)

    def __repr__(self) -> str:
        return f"<LIN bus {self.name}>"
