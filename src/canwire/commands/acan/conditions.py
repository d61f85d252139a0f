"""What the driver reports besides messages, in words for people.

Source: INduCAN104 manual, "Special conditions"; SJA1000 data sheet 6.4.9 (error code capture).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from canwire.acan import BlockStatus, Condition
from canwire.commands.dump.words import ECC_PLACES

if TYPE_CHECKING:
    from canwire.acan import TaskBlock

WATCHED = Condition.BUSERR | Condition.ERRPAS | Condition.OVERRUN | Condition.NOBUFF | Condition.BUSOFF

_KINDS = ("bit error", "form error", "stuff error", "bus error")


class News(NamedTuple):
    """What happened: a line for each thing, and whether the controller has left the bus."""

    lines: list[str]
    bus_off: bool


def news(block: TaskBlock) -> News:
    """What happened since the last call; clears the block's status."""
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
    """The text of an SJA1000 error code: `bus error at the acknowledge slot, sending: nobody acknowledges`."""
    kind, place = _KINDS[code >> 6 & 3], code & 0x1F
    way = "receiving" if code & 0x20 else "sending"
    where = f" at the {ECC_PLACES[place]}" if place in ECC_PLACES else ""
    why = ": nobody acknowledges" if place == 0x19 and way == "sending" else ""
    return f"{kind}{where}, {way}{why}"


def _counters(block: TaskBlock) -> str:
    return f"TEC {block.tec}, REC {block.rec}"
