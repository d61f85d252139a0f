"""A bus of a lab as a python-can channel: each channel has a separate board there, in the lab's time."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from canwire import BadValue, Hub, Lab, LabBus

_BOARD = "usb-to-can-fd"


class Held(Protocol):
    """An object that a bus closes at its end."""

    def close(self) -> None: ...


class Placed(NamedTuple):
    """A channel: its name for display, its line at that hub, rates in bit/s, and the objects to close at its end."""

    name: str
    line: str
    hub: str | Hub | None
    rates: tuple[int | None, int | None]
    held: list[Held]


def placed(
    channel: str | LabBus, hub: str | Hub | Lab | None, rates: tuple[int | None, int | None]
) -> Placed:
    """The place of a channel: as given for a hub; for a lab's bus, a new board, by default with the bus's rates.

    Raises BadValue if the lab does not have that bus.
    """
    if isinstance(channel, LabBus):
        bus = channel
    elif not isinstance(hub, Lab):
        return Placed(channel, str(channel), hub, rates, [])
    elif channel in hub.buses:
        bus = hub.buses[channel]
    else:
        raise BadValue(f"this lab has no CAN bus {channel!r}; there are {', '.join(hub.buses) or 'none'}")
    board = BenchBoard(bus)
    data = None if bus.data_timing is None else bus.data_timing.bit_rate
    return Placed(
        bus.name, board.line, board.hub, (rates[0] or bus.timing.bit_rate, rates[1] or data), [board]
    )


class BenchBoard:
    """A board on a lab's bus whose first `line` is for one program."""

    def __init__(self, bus: LabBus) -> None:
        lab = bus.time
        assert isinstance(lab, Lab)  # every lab's buses are made by one
        self.hub = lab.hub()
        self._id = self.hub.plug(_BOARD, buses=(bus.name, "", "")).hardware_id
        self.line = f"{self._id}:0"

    def close(self) -> None:
        """Unplug the board."""
        if not self.hub.lost:
            self.hub.unplug(self._id)
