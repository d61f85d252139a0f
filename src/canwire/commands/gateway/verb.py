"""`canwire bridge`: pass frames between two buses, of one hub or two, or between a bus and a CAN interface of Linux.

canwire bridge can0 can1                                all frames, in both directions
canwire bridge can0 can1 --filter 100:700 --map 100=200  some frames only, 100 with identifier 200
canwire bridge can0 can1 --one-way --rate 100           at most 100 frames in any second
canwire bridge can0 can1 --change 123:0=80/80           set bit 7 of byte 0 in frame 123
canwire bridge can0 can0 --to-hub /run/other.sock       can0 of this hub and can0 of another hub
canwire bridge can0 vcan0                               an interface of the kernel, which must exist and be up

A name of a bus and of an interface means the bus: write `kernel:can0` for the interface. While the bridge runs, stderr
reports frames discarded by a limit or a full queue. Ctrl-C ends the bridge; stderr then gives the counts of each
direction. Gateways that would pass frames in a circle are refused.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack

import canwire
from canwire import Gateway, Hub, LinePlace, NoSuchBoard, find_lines
from canwire.commands.can_line import add_line_arguments, bring_up, wanted_by
from canwire.commands.console import complain
from canwire.commands.gateway.limits import Limits
from canwire.commands.gateway.rules import add_rule_arguments, rules_by
from canwire.commands.reconnecting import add_reconnect_argument, going_on
from canwire.commands.shared_hub import connected, find_line

_KERNEL = "kernel:"
_LOOK_S = 1.0  # between two looks at what limits hold back


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_line_arguments(parser)
    parser.add_argument(
        "other", metavar="OTHER", help="a second line or bus, or a CAN interface of the kernel"
    )
    parser.add_argument("--to-hub", metavar="ADDRESS", help="the hub of OTHER, if it is another one")
    add_reconnect_argument(parser)
    add_rule_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Pass frames on until Ctrl-C. Raises HubError without a hub or interface, OSError when an interface goes down."""
    return going_on(arguments, _pass_on)


def _pass_on(arguments: argparse.Namespace) -> int:
    with ExitStack() as closing:
        hub = connected(arguments, "bridge", closing)
        other_hub = hub
        if arguments.to_hub is not None:
            other_hub = closing.enter_context(canwire.connect(arguments.to_hub, name="canwire bridge"))
        elif _is_kernels(hub, arguments.other):
            from canwire.commands.gateway.kernel import join

            return join(arguments, hub, arguments.other.removeprefix(_KERNEL))
        there, back = rules_by(arguments)
        first = find_line(hub, arguments.line, to_send=True)
        second = find_line(other_hub, arguments.other, to_send=True)
        _start(hub, first, arguments)
        _start(other_hub, second, arguments)
        gateway = closing.enter_context(
            Gateway(first, second, there=there, back=back, hub=hub, other_hub=other_hub)
        )
        names = [f"{place.address} on {place.info.bus or 'no bus'}" for place in (first, second)]
        complain(f"{names[0]} {'to' if arguments.one_way else 'and'} {names[1]}: passing on")
        limits = Limits("there", complain), Limits("back", complain)
        try:
            while not gateway.wait(_LOOK_S):
                limits[0].look(gateway.there)
                limits[1].look(gateway.back)
        finally:
            gateway.close()  # then nothing waits any more
            complain(f"there: {gateway.there}" + ("" if arguments.one_way else f"; back: {gateway.back}"))
    return 0


def _start(hub: Hub, place: LinePlace, arguments: argparse.Namespace) -> None:
    """Start the line at the rates of the command line; without any, the gateway uses those of the bus."""
    if arguments.bit_rate is not None or arguments.data_bit_rate is not None:
        bring_up(hub, place, wanted_by(arguments))


def _is_kernels(hub: Hub, name: str) -> bool:
    if name.startswith(_KERNEL):
        return True
    try:
        find_lines(hub, name)
    except NoSuchBoard:
        return True
    return False
