"""Access layers of boards: any number of clients share one, two layers exclude each other."""

from __future__ import annotations

from dataclasses import dataclass

from canwire.hub.owner.held.held import Held


@dataclass(eq=False)
class HeldLayer(Held):
    """A share of a board's access layer."""

    board: int
    layer: str

    def is_on(self, board: int) -> bool:
        return board == self.board
