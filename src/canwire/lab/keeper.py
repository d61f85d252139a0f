"""Lets the virtual time of a lab pass for the threads of a program (canwire.in_time)."""

from __future__ import annotations

from collections.abc import Callable

from canwire.held_time import HeldTime
from canwire.timeline import Timeline


class LabKeeper:
    """`kick` is called before time passes."""

    lost = False
    alone = True

    def __init__(self, timeline: Timeline, held: HeldTime, kick: Callable[[], object]) -> None:
        self._timeline = timeline
        self._held = held
        self._kick = kick

    def now_ns(self) -> int:
        return self._timeline.now_ns

    def pass_time(self, now_ns: int, until_ns: int) -> int:
        self._kick()
        self._held.run(self._timeline, until_ns)
        self._held.rest()
        return self._timeline.now_ns

    def leave(self) -> None:
        """Do nothing: no other program waits for this one."""

    def rejoin(self) -> None:
        """Do nothing, like `leave`."""
