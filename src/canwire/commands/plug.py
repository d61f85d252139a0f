"""`canwire plug`: put a board into the hub; programs that use the hub see it appear.

canwire plug usb-to-can-fd                              a serial number of the hub's choice, on the kind's usual buses
canwire plug usb-to-can --serial HW123456 --bus can0 can1
canwire plug inducan104 --base 300 --irq 7
canwire plug slcan --port /dev/ttyUSB0                  a real adapter; `canwire share` is shorter
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack

from canwire import BoardInfo
from canwire.commands.shared_hub import add_hub_argument, connected


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "kind", metavar="KIND", help="kind of the board: usb-to-can-fd, usb-to-can, inducan104, pc-i04, ..."
    )
    parser.add_argument("--serial", default="", metavar="HW...", help="its hardware id (default: a free one)")
    parser.add_argument(
        "--bus", nargs="+", action="extend", default=[], metavar="NAME", help="a bus for each of its lines"
    )
    parser.add_argument(
        "--base", type=hexadecimal, metavar="PORT", help="inducan104: its address in hex (default 280)"
    )
    parser.add_argument("--irq", type=int, metavar="N", help="inducan104: its interrupt line (default 5)")
    parser.add_argument(
        "--shared-irq",
        action="store_true",
        help="share that line with boards that have --shared-irq too",
    )
    parser.add_argument(
        "--port",
        default="",
        metavar="PORT",
        help="slcan, slcan-fd: /dev/ttyUSB0, COM3, socket://host:port; python-can: pcan/PCAN_USBBUS1",
    )
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Plug it in and print its line; NoSuchBoard for an unknown kind or bus, HubError without a hub."""
    with ExitStack() as closing:
        hub = connected(arguments, "plug", closing)
        board = hub.plug(
            arguments.kind,
            arguments.serial,
            tuple(arguments.bus),
            base=arguments.base,
            irq=arguments.irq,
            shared_irq=arguments.shared_irq,
            port=arguments.port,
        )
        print(board_line(board))
    return 0


def hexadecimal(text: str) -> int:
    """Return the number in a hexadecimal text: 280, 280h or 0x280."""
    return int(text.removesuffix("h"), 16)


def board_line(board: BoardInfo) -> str:
    """A board in one line: hardware id, kind, description, buses; - where a line is unconnected."""
    buses = " ".join(line.bus or "-" for line in board.lines)
    return f"{board.hardware_id}  {board.kind}  {board.description}  {buses}"
