"""`canwire unplug`: pull a board out of the hub; programs that use it get an error that says so.

canwire unplug HW000001    the board with this hardware id
canwire unplug HW000002    `canwire devices` lists them
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack

from canwire.commands.plug import board_line
from canwire.commands.shared_hub import add_hub_argument, connected


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("hardware_id", metavar="HARDWARE_ID", help="as `canwire devices` shows it: HW000001")
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Pull it out and print its line; NoSuchBoard if there is none, HubError without a hub."""
    with ExitStack() as closing:
        hub = connected(arguments, "unplug", closing)
        board = next((one for one in hub.boards() if one.hardware_id == arguments.hardware_id), None)
        hub.unplug(arguments.hardware_id)
        if board is not None:
            print(board_line(board))
    return 0
