"""`canwire plug`: put a board into the hub; every program that shares it sees it come.

canwire plug usb-to-can-fd                              a serial number of the hub's choice, on the kind's usual buses
canwire plug usb-to-can --serial HW123456 --bus can0 can1
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack

from canwire import BoardInfo
from canwire.commands.hub_line import add_hub_argument, connected


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    parser.add_argument(
        "kind", metavar="KIND", help="kind of the board: usb-to-can-fd, usb-to-can, or a plug-in's"
    )
    parser.add_argument("--serial", default="", metavar="HW...", help="its hardware id (default: a free one)")
    parser.add_argument(
        "--bus", nargs="+", action="extend", default=[], metavar="NAME", help="a bus for each of its lines"
    )
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Plug it in and print its line; NoSuchBoard for an unknown kind or bus, HubError without a hub."""
    with ExitStack() as closing:
        hub = connected(arguments, "plug", closing)
        print(board_line(hub.plug(arguments.kind, arguments.serial, tuple(arguments.bus))))
    return 0


def board_line(board: BoardInfo) -> str:
    """A board in one line: hardware id, kind, description, buses; - where a line is unconnected."""
    buses = " ".join(line.bus or "-" for line in board.lines)
    return f"{board.hardware_id}  {board.kind}  {board.description}  {buses}"
