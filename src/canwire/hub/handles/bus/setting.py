"""The common part of the faults of CAN and LIN buses."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypedDict

from canwire.errors import BadValue
from canwire.hub.handles.bus.fault import HubFault
from canwire.hub.protocol import fault_messages as f
from canwire.hub.protocol import messages as m

if TYPE_CHECKING:
    from canwire.hub.handles.client import Client


class FaultStay(TypedDict, total=False):
    """How long a fault stays: `lasting` seconds of the hub's time, else until it is cancelled, used up, or its program
    ends; with `persistent` also after that."""

    lasting: float | None
    persistent: bool


class BusFaults:
    """The faults on one bus of a hub. Methods raise BadValue or NoSuchBoard for invalid arguments."""

    def __init__(self, hub: Client, bus: str) -> None:
        self._hub = hub
        self._bus = bus

    def __repr__(self) -> str:
        return f"<faults of {self._bus}>"

    def list(self) -> tuple[f.FaultInfo, ...]:
        """The faults of all programs here, in the order in which they were set, with the programs that set them."""
        faults: tuple[f.FaultInfo, ...] = self._hub.call(m.ListFaults(self._bus)).faults
        return faults

    def clear(self, *, left: bool = False, everybody: bool = False) -> int:
        """End this program's faults, with `left` also persistent ones, with `everybody` all; returns how many ended."""
        whose = "all" if everybody else "left" if left else "mine"
        return int(self._hub.call(m.ClearFaults(self._bus, whose)).value)

    def disconnect(self, line: str, *, lasting: float | None = None, persistent: bool = False) -> HubFault:
        """Disconnect a line from its bus immediately, even within a frame; `cancel` reconnects it."""
        return self._set(f.Disconnect(line), {"lasting": lasting, "persistent": persistent})

    def _set(self, fault: f.Fault, stay: FaultStay) -> HubFault:
        lasting = stay.get("lasting")
        if lasting is not None and not 0 < lasting < 1e9:
            raise BadValue(f"lasting {lasting!r}: seconds, more than 0")
        span_ns = None if lasting is None else max(1, round(lasting * 1e9))
        request = m.SetFault(self._bus, fault, span_ns, stay.get("persistent", False))
        return HubFault(self._hub, self._hub.call(request).handle, self._bus)
