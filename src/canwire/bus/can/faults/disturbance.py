"""Disturbances of a wire: at a place, each time that a node gets there, or once at a given time."""

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
    """What is to happen at a place: `shape` gives the changes for a node's bit and quantum (ps) there."""

    place: Place
    shape: Callable[[int, int], Changes]
    seen_by: str | list[Node]


@dataclass(slots=True, eq=False)
class Timed(Scripted):
    """What is to happen once, at a time; `stimulus` is what is happening."""

    timer: Timer | None = None
    stimulus: Stimulus | None = None


def stimulus_of(start_ps: int, changes: Changes, nodes: list[Node] | None) -> Stimulus:
    """These changes from that time on."""
    return Stimulus([start_ps + at for at, _ in changes], [level for _, level in changes], nodes)


def level_of(name: str) -> int:
    """A level by its name."""
    if name not in LEVELS:
        raise BadValue(f"level {name!r}: dominant or recessive")
    return LEVELS[name]
