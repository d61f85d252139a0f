"""The cells of table.py for real adapters that are shared: where their answers differ from those of simulated boards.

SLCAN is an emulated dongle, so that its copper can be disturbed; PYTHON_CAN is python-can's `virtual`, which has
neither errors nor plugs. docs/sharing.md shows what differs.
"""

from __future__ import annotations

from tests.together.table import (
    ACAN,
    CAN_STOP,
    DONGLE,
    EVENTS,
    INT2D,
    JOIN_STOPPED,
    KINDS,
    RECOVER,
    Cell,
    spread,
)

SLCAN, PYTHON_CAN = "slcan", "python-can"
ADAPTERS = (SLCAN, PYTHON_CAN)

ADAPTER_REFUSES = dict.fromkeys(((ACAN, PYTHON_CAN), (INT2D, PYTHON_CAN)), "ACAN_Init 0")
"""What a program is told that tries to open a line which its interface cannot drive."""

NOT_APPLICABLE = {(PYTHON_CAN, RECOVER): "`virtual` reports no errors, so its line is never bus-off"}
"""What cannot happen to an adapter, and why."""


HOST_STAYS_AWAY = "not applicable: it sets up its own board and joins no other"


def programs(adapter: str) -> list[str]:
    """Who can be on it."""
    return [kind for kind in KINDS if kind != DONGLE and (kind, adapter) not in ADAPTER_REFUSES]


def _pairs(adapter: str, event: str, every: bool) -> list[tuple[str, str]]:
    starters = [kind for kind in programs(adapter) if event != JOIN_STOPPED or kind in CAN_STOP]
    actors = [kind for kind in programs(adapter) if kind in EVENTS[event]]
    if every:
        return [(starter, actor) for starter in starters for actor in actors]
    return spread(starters, actors, ADAPTERS.index(adapter) + list(EVENTS).index(event))


def adapter_cells(*, every: bool) -> list[Cell]:
    """With `every` pair of programs, or each of them starting and acting once in everything that happens."""
    return [
        Cell(adapter, starter, actor, event)
        for adapter in ADAPTERS
        for event in EVENTS
        if (adapter, event) not in NOT_APPLICABLE
        for starter, actor in _pairs(adapter, event, every)
    ]
