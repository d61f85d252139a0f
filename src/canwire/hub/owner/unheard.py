"""Whether any program can notice when a hub checks its buses: if not, it may check later, and all stamps stay exact."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from canwire.boards.board import Board
    from canwire.hub.owner.world import World


def unheard(world: World) -> bool:
    """Programs are there, but none has a queue or awaits anything, and no board has a bus outside.

    What they ask finds the bus's time, since time is caught up with before anything is answered.
    """
    if world.reactor is None or world.reactor.used or not world.sessions:
        return False
    for session in world.sessions:
        if session.listens:
            return False
    return not any(_is_real(board) for board in world.boards.values())


def _is_real(board: Board) -> bool:
    """A card in this machine: it has ports, and no model behind them."""
    return board.card is None and bool(board.info.resources)
