"""A hub with a board of each kind of controller, and programs on its lines."""

from __future__ import annotations

from canwire import (
    BusEvent,
    ChannelMode,
    ErrorKind,
    EventKind,
    Frame,
    Hub,
    HubChannel,
    WantedMode,
    find_lines,
)
from canwire.bus.can.node import Node

CONFIG = """
[[bus]]
name = "can0"
[[bus]]
name = "lin0"
type = "lin"
[[board]]
kind = "usb-to-can-fd"
serial = "HW000001"
buses = ["can0", "can0", "lin0"]
[[board]]
kind = "inducan104"
serial = "HW000003"
buses = ["can0"]
[[board]]
kind = "picocom1"
serial = "HW000004"
buses = ["can0"]
"""
IDEAL, OTHER, SJA1000, MCP2515, LIN = "HW000001:0", "HW000001:1", "HW000003:0", "HW000004:0", "HW000001:2"
FRAME = Frame(0x123, b"\x11\x22")
LONG_S = 30.0


class Program:
    """On a line that it sets up and starts, with frames and events in one queue."""

    def __init__(self, hub: Hub, line: str, bit_rate: int | None = None) -> None:
        (self.place,) = find_lines(hub, line)
        self.hub = hub
        self.channel: HubChannel = hub.open_channel(self.place.board.id, self.place.line)
        self.channel.set_up(ChannelMode(4096, 4096, events=tuple(int(kind) for kind in EventKind)))
        self.channel.activate()
        with hub.open_control(self.place.board.id, self.place.line) as control:
            control.initialise(WantedMode(bit_rate).mode(self.place.info.capabilities))
            control.start()

    def send(self, frame: Frame = FRAME, count: int = 1) -> None:
        for _ in range(count):
            self.channel.send(frame)

    def received(self, timeout: float = LONG_S) -> list[Frame | BusEvent]:
        """Frames and errors since the last call, waiting for the first frame."""
        found: list[Frame | BusEvent] = []
        while (item := self.channel.receive_any(timeout)) is not None:
            found.append(item)
            if isinstance(item, Frame):
                timeout = 0
        return found

    def frames(self, timeout: float = LONG_S) -> list[Frame]:
        return [item for item in self.received(timeout) if isinstance(item, Frame)]

    def errors(self) -> list[ErrorKind]:
        """What kinds of errors its controller has noticed since the last call."""
        found = []
        while (item := self.channel.receive_any(0)) is not None:
            if isinstance(item, BusEvent) and item.kind == EventKind.ERROR:
                found.append(item.error)
        return found

    def lost(self) -> int:
        return self.channel.status().lost


def bit_times(node: Node) -> list[int]:
    """Everything about a controller's bit times, in picoseconds."""
    phases = [
        f"{phase}{part}"
        for phase in ("", "data_")
        for part in ("bit_ps", "sample_ps", "quantum_ps", "jump_ps")
    ]
    return [getattr(node, name) for name in (*phases, "phase1_ps")]
