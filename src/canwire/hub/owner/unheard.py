"""Whether any program can notice when a hub checks its buses: if not, it may check later, and all stamps stay exact."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from canwire.boards.board import Board
    from canwire.hub.owner.world import World


def unheard(world: World) -> bool:
    """True if programs are connected, none has a queue or waits for an event, and no board has a real bus.

    Answers to their requests are still exact, since the hub catches up with the time before it answers.
    """
    if world.reactor is None or world.reactor.used or not world.sessions:
        return False
    for session in world.sessions:
        if session.listens:
            return False
    return not any(_is_real(board) for board in world.boards.values())


def _is_real(board: Board) -> bool:
    """Whether the board is a real card in this machine: it has ports, but no model."""
    return board.card is None and bool(board.info.resources)
