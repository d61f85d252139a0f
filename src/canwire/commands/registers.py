"""`canwire registers`: the registers of a board's chip, decoded; reading them changes nothing.

canwire registers HW000003
canwire registers inducan104 --follow        every half second what has changed, until Ctrl-C
"""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import BoardInfo, NoSuchBoard, RegisterValue, Unsupported
from canwire.commands.shared_hub import add_hub_argument, connected

if TYPE_CHECKING:
    from canwire import Hub

_HOME_AND_CLEAR = "\x1b[H\x1b[J"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("board", metavar="BOARD", help="HW000003, or a kind: inducan104")
    parser.add_argument(
        "--line", type=int, default=0, metavar="N", help="which of its lines (default: %(default)s)"
    )
    parser.add_argument("--follow", action="store_true", help="keep looking, and show what changes")
    parser.add_argument(
        "--interval",
        type=float,
        default=0.5,
        metavar="S",
        help="seconds between two looks (default: %(default)s)",
    )
    parser.add_argument("--count", type=int, metavar="N", help="end after looking this many times")
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print the registers; NoSuchBoard, Unsupported for a chip without any, HubError without a hub."""
    with ExitStack() as closing:
        hub = connected(arguments, "registers", closing)
        board = hub.board(arguments.board)
        if not 0 <= arguments.line < len(board.lines):
            raise NoSuchBoard(f"{board.hardware_id} has the lines 0 to {len(board.lines) - 1}")
        if not arguments.follow:
            print("\n".join(table(_values(hub, board, arguments.line))))
            return 0
        _follow(hub, board, arguments)
    return 0


def table(values: Sequence[RegisterValue], changed: frozenset[str] = frozenset()) -> list[str]:
    """Return a line for each register: address, name, value, its bits in words; * marks changed registers."""
    width = max(len(value.name) for value in values)
    return [
        f"{value.address:3} {value.name:<{width}} {value.value:02X} {value.value:08b}"
        f" {'*' if value.name in changed else ' '} {value.text}".rstrip()
        for value in values
    ]


def _values(hub: Hub, board: BoardInfo, line: int) -> tuple[RegisterValue, ...]:
    values = hub.registers(board.id, line)
    if not values:
        raise Unsupported(
            f"{board.hardware_id} ({board.kind}): line {line} has an ideal controller, without registers"
        )
    return values


def _follow(hub: Hub, board: BoardInfo, arguments: argparse.Namespace) -> None:
    """Print the registers at each interval: on a terminal the whole table, elsewhere only the changed lines."""
    before: tuple[RegisterValue, ...] = ()
    pause = threading.Event()
    looks = 0
    while True:
        values = _values(hub, board, arguments.line)
        changed = frozenset(value.name for value in values if value not in before)
        if sys.stdout.isatty():
            print(_HOME_AND_CLEAR + "\n".join(table(values, changed if before else frozenset())), flush=True)
        elif changed:
            print("\n".join(table([value for value in values if value.name in changed])), flush=True)
        before = values
        looks += 1
        if looks == arguments.count:
            return
        pause.wait(arguments.interval)
