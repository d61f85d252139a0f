"""Levels forced at receivers, but not by a node: what ISO 16845-1 calls the lower tester.

bit_level.py applies them while there are any; forcing.py creates them.
"""

from __future__ import annotations

from canwire.bus.can.node import Node
from canwire.timeline import NEVER

_NEVER = NEVER
FREE = -1
_FREE = FREE


class Stimulus:
    """One level after another, from given times on, for some nodes or (None) for the wire itself.

    `times_ps` rise and count from the timeline's start; `levels` are 0 (dominant), 1 (recessive) or FREE, which
    leaves the wire's own level. The stimulus is over after the last one. `level` is the present one, `next_ps` the time
    of the next change.
    """

    def __init__(self, times_ps: list[int], levels: list[int], nodes: list[Node] | None) -> None:
        self.times_ps = times_ps
        self.levels = levels
        self.nodes = nodes
        self.level = _FREE
        self.position = 0
        self.next_ps = times_ps[0] if times_ps else _NEVER

    def advance(self, at_ps: int) -> None:
        """Apply all changes up to this time."""
        while self.next_ps <= at_ps and 0 <= self.position < len(self.levels):
            self.level = self.levels[self.position]
            self.position += 1
            more = self.position < len(self.times_ps)
            self.next_ps = self.times_ps[self.position] if more else _NEVER

    def over(self) -> bool:
        """Whether all levels have been forced."""
        return self.next_ps == _NEVER
