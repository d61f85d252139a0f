"""`canwire stop`: take a line off its bus; the programs that use it see it stop.

canwire stop HW000001:0
canwire stop can0              every line on can0
canwire stop can0 --reset      the same, and forget their settings and filters
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import LinePlace, find_lines
from canwire.commands.shared_hub import add_hub_argument, add_line_argument, connected

if TYPE_CHECKING:
    from canwire import Hub


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_line_argument(parser, "HW000001:0, usb-to-can-fd:1, or the name of a bus: can0")
    parser.add_argument("--reset", action="store_true", help="forget settings and filters too")
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Stop the line and print which lines were stopped; InUse while a program has the line's control."""
    with ExitStack() as closing:
        hub = connected(arguments, "stop", closing)
        for place in find_lines(hub, arguments.line):
            if place.info.lin is not None or not (arguments.reset or place.status(hub).running):
                continue
            stop(hub, place, reset=arguments.reset)
            print(f"{place.address} {'reset' if arguments.reset else 'stopped'}")
    return 0


def stop(hub: Hub, place: LinePlace, *, reset: bool = False) -> None:
    """Take the line off its bus for all its programs; with `reset` it also forgets its settings. Raises InUse."""
    with hub.open_control(place.board.id, place.line) as control:
        if reset:
            control.reset()
        else:
            control.stop()
