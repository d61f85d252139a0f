"""`canwire line`: start, stop or reset a CAN line of the hub, or have it begin again after bus-off.

canwire line HW000003:0 reset        it leaves its bus and forgets how it was set up
canwire line HW000003:0 stop         it leaves its bus, for everybody on it
canwire line HW000003:0 start        it takes part again, as it was set up
canwire line HW000003:0 recover      after bus-off, whoever configured it

All but `recover` take the line's control for a moment, and are refused while somebody holds it.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import Control, ErrorState, LinePlace, LineStatus, format_rates, format_setter
from canwire.commands.shared_hub import add_hub_argument, add_line_argument, connected, find_line

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import Hub

_ACTIONS: dict[str, Callable[[Control], None]] = {
    "start": lambda control: control.start(),
    "stop": lambda control: control.stop(),
    "reset": lambda control: control.reset(),
}
RECOVER = "recover"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    add_line_argument(parser, "HW000001:0, usb-to-can-fd:1, or the name of a bus: can0")
    parser.add_argument("action", choices=(*_ACTIONS, RECOVER), help="what is to be done with it")
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Do it, and say how the line is then; InUse, NotInitialised, NoSuchBoard, HubError for what cannot be."""
    with ExitStack() as closing:
        hub = connected(arguments, "line", closing)
        place = find_line(hub, arguments.line)
        act(hub, place, arguments.action)
        print(f"{place.address}: {state_text(place.status(hub))}")
    return 0


def act(hub: Hub, place: LinePlace, action: str) -> None:
    """One of the verb's actions."""
    if action == RECOVER:
        with hub.open_channel(place.board.id, place.line):
            hub.recover(place.board.id, place.line)
        return
    with hub.open_control(place.board.id, place.line) as control:
        _ACTIONS[action](control)


def state_text(status: LineStatus) -> str:
    """`error active, 500000 bit/s, set by canwire dump (123)`"""
    if not status.initialised:
        return "not initialised"
    state = ErrorState(status.state).name.lower().replace("_", " ")
    return f"{state}, {format_rates(status.mode)}, {format_setter(status)}"
