"""Disturbances of the wire: at a place, each time that a node reaches it, or once at a given time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from canwire.bus.can.faults.places import Place
from canwire.bus.can.node import Node
from canwire.bus.can.stimulus import FREE, Stimulus
from canwire.bus.scripted import Scripted
from canwire.errors import BadValue
from canwire.timeline import Timer

LEVELS = {"dominant": 0, "recessive": 1}
SIGNS = {"0": 0, "1": 1, "-": FREE}
Changes = list[tuple[int, int]]  # (ps from the place, level)


@dataclass(slots=True, eq=False)
class Disturbance(Scripted):
    """A disturbance at a place: `shape` returns the changes of level for a node's bit and quantum (ps) there."""

    place: Place
    shape: Callable[[int, int], Changes]
    seen_by: str | list[Node]


@dataclass(slots=True, eq=False)
class Timed(Scripted):
    """A disturbance at a given time; `stimulus` is set while it is in progress."""

    timer: Timer | None = None
    stimulus: Stimulus | None = None


def stimulus_of(start_ps: int, changes: Changes, nodes: list[Node] | None) -> Stimulus:
    """A stimulus with these changes, from `start_ps` on."""
    return Stimulus([start_ps + at for at, _ in changes], [level for _, level in changes], nodes)


def level_of(name: str) -> int:
    """The level (0 or 1) of a name; raises BadValue for an unknown one."""
    if name not in LEVELS:
        raise BadValue(f"level {name!r}: dominant or recessive")
    return LEVELS[name]
