"""What the driver reports besides messages, in words for people.

Source: INduCAN104 manual (seed 001), "Special conditions"; SJA1000 data sheet 6.4.9 (error code capture).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from canwire.acan import BlockStatus, Condition

if TYPE_CHECKING:
    from canwire.acan import TaskBlock

WATCHED = Condition.BUSERR | Condition.ERRPAS | Condition.OVERRUN | Condition.NOBUFF | Condition.BUSOFF

_KINDS = ("bit error", "form error", "stuff error", "bus error")
_PLACES = {
    0x02: "identifier", 0x03: "start of frame", 0x04: "SRTR bit", 0x05: "IDE bit", 0x06: "identifier",
    0x07: "identifier", 0x08: "CRC", 0x09: "reserved bit 0", 0x0A: "data", 0x0B: "length", 0x0C: "RTR bit",
    0x0D: "reserved bit 1", 0x0E: "identifier", 0x0F: "identifier", 0x11: "active error flag",
    0x12: "intermission", 0x13: "tolerated dominant bits", 0x16: "passive error flag", 0x17: "error delimiter",
    0x18: "CRC delimiter", 0x19: "acknowledge slot", 0x1A: "end of frame", 0x1B: "acknowledge delimiter",
    0x1C: "overload flag",
}  # fmt: skip


class News(NamedTuple):
    """What happened: a line for each thing, and whether the controller has left the bus."""

    lines: list[str]
    bus_off: bool


def news(block: TaskBlock) -> News:
    """Since the last call; clears the block's status."""
    status = block.acknowledge()
    happened = status.conditions
    lines = _of_the_bus(block, happened)
    if happened & Condition.OVERRUN:
        lines.append("the controller lost messages: nobody took them in time")
    if happened & Condition.NOBUFF:
        lines.append("the driver lost messages: it has no buffer left")
    if status.flags & BlockStatus.OVERFLOW:
        lines.append("messages were lost: they came faster than they were taken")
    return News(lines, bool(happened & Condition.BUSOFF))


def _of_the_bus(block: TaskBlock, happened: Condition) -> list[str]:
    lines = []
    if happened & Condition.BUSERR:
        lines.append(bus_error(block.ecc))
    if happened & Condition.ARBLOST:
        lines.append(f"arbitration lost in bit {block.alc}")
    if happened & Condition.ERRLIM:
        lines.append(f"error counters at their limit: {_counters(block)}")
    if happened & Condition.ERRPAS:
        lines.append(f"error passive: {_counters(block)}")
    if happened & Condition.BUSOFF:
        lines.append("bus-off: the error counters are full")
    return lines


def bus_error(code: int) -> str:
    """Of SJA1000's error code: `bus error at the acknowledge slot, sending: nobody acknowledges`."""
    kind, place = _KINDS[code >> 6 & 3], code & 0x1F
    way = "receiving" if code & 0x20 else "sending"
    where = f" at the {_PLACES[place]}" if place in _PLACES else ""
    why = ": nobody acknowledges" if place == 0x19 and way == "sending" else ""
    return f"{kind}{where}, {way}{why}"


def _counters(block: TaskBlock) -> str:
    return f"TEC {block.tec}, REC {block.rec}"
