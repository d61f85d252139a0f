"""The LEDs that a board would show: green for traffic, red for errors, yellow for a pending interrupt.

Green and red as on the CANBUS dongle (CANBUS manual 1.2: red blinks at an error, is constant at a bus error, and
does not show a lost arbitration), yellow as on the INduCAN104.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from canwire import ErrorState
from canwire.web.boards.registers import registers_now

if TYPE_CHECKING:
    from canwire import Hub
    from canwire.web.lines import Line

_INTERRUPTS = ("IR", "CANINTF")  # of SJA1000 and MCP2515
_BASIC_CAN_SOURCES = 0x1F


@dataclass(frozen=True)
class Leds:
    """Each is "off", "blinking" or "lit"; yellow is None where the chip has no register of interrupts."""

    green: str
    red: str
    yellow: str | None


def leds_of(hub: Hub, line: Line) -> Leds:
    """Return the LEDs for the status of the line and the interrupt register of its chip."""
    status = line.can
    assert status is not None
    state = ErrorState(status.state)
    if not status.initialised or state is ErrorState.STOPPED:
        red = "off"
    elif state is ErrorState.BUS_OFF or status.coupling_fault:
        red = "lit"
    else:
        red = "blinking" if status.tec or status.rec else "off"
    return Leds("lit" if status.running and status.load > 0 else "off", red, _yellow(hub, line))


def _yellow(hub: Hub, line: Line) -> str | None:
    registers = {one.name: one.value for one in registers_now(hub, line.place)}
    waiting = [registers[name] for name in _INTERRUPTS if name in registers]
    if not waiting:
        return None
    basic_can = "CR" in registers  # there the reserved bits of IR read as 1 (SJA1000 data sheet 6.3.6)
    return "lit" if waiting[0] & (_BASIC_CAN_SOURCES if basic_can else 0xFF) else "off"
