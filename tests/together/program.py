"""A program in a process of its own, which sets a line up and then does nothing: `python -m tests.together.program`.

Words: its kind, the hub's address. It prints what it was told, and ends when its input does.
"""

from __future__ import annotations

import sys

import canwire
from tests.together.players.every import PLAYERS
from tests.together.scene import BOARD


def main(kind: str, address: str) -> None:
    hub = canwire.connect(address, name=kind)
    program = PLAYERS[kind](hub, hub.board(BOARD))
    print(program.set_up(), flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main(*sys.argv[1:])
