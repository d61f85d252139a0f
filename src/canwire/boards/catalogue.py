"""Board kinds by name, and the only place that puts chips on buses."""

from __future__ import annotations

from canwire.boards.line import Line
from canwire.bus.can_bus import CanBus
from canwire.drivers.can_fd import CanFdDriver
from canwire.timeline import Timeline


def ideal_line(name: str, timeline: Timeline) -> Line:
    """A line with the ideal CAN FD controller and its driver, not yet on any bus."""
    line = Line(name, timeline)
    line.driver = CanFdDriver(line.controller)
    return line


def plug(line: Line, bus: CanBus) -> None:
    """Put a line's controller on a bus."""
    bus.attach(line.controller)


def unplug(line: Line) -> None:
    """Take a line's controller off its bus, wherever that is."""
    bus = line.controller.bus
    if isinstance(bus, CanBus):
        bus.detach(line.controller)
