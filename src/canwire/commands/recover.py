"""`canwire recover`: restart a line after bus-off, whichever program configured it.

canwire recover HW000003:0        the line of that address
canwire recover can0              every line on can0 that is bus-off

The line leaves its bus and joins it again with clean counters. The line's control is neither needed nor taken. Frames
that waited to be sent are sent then, unless their program cancelled them. Exit status 1 if no such line was bus-off.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import BadValue, ErrorState, LinePlace, LineStatus, find_lines, format_rates, format_setter
from canwire.commands.console import complain
from canwire.commands.shared_hub import add_hub_argument, add_line_argument, connected

if TYPE_CHECKING:
    from canwire import Hub


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_line_argument(parser, "HW000001:0, usb-to-can-fd:1, or the name of a bus: can0")
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Recover the lines and print the state of each; raises BadValue for a LIN line, NoSuchBoard, InUse.

    InUse means that one program uses the line exclusively.
    """
    with ExitStack() as closing:
        hub = connected(arguments, "recover", closing)
        places = find_lines(hub, arguments.line)
        if places[0].info.lin is not None:
            raise BadValue(f"{arguments.line}: {places[0].address} is a LIN line, which knows no bus-off")
        off = [place for place in places if place.status(hub).state == ErrorState.BUS_OFF]
        for place in off:
            recover(hub, place)
            print(f"{place.address}: {state_text(place.status(hub))}")
        if not off:
            for place in places:
                complain(f"{place.address} is not bus-off: {state_text(place.status(hub))}")
    return int(not off)


def recover(hub: Hub, place: LinePlace) -> None:
    """Recover the line; this program opens a channel for it, as only programs with a part in a line may do so."""
    with hub.open_channel(place.board.id, place.line):
        hub.recover(place.board.id, place.line)


def state_text(status: LineStatus) -> str:
    """`error active, 500000 bit/s, set by canwire dump (123)`"""
    if not status.initialised:
        return "not initialised"
    state = ErrorState(status.state).name.lower().replace("_", " ")
    return f"{state}, {format_rates(status.mode)}, {format_setter(status)}"
