"""`canwire bridge`: join a bus of the hub and a CAN interface of the kernel.

canwire bridge can0 vcan0              what is sent on either is on both
canwire bridge HW000001:0 can0         by this line of the hub; the kernel's can0 may be a real adapter

The kernel's interface has to be there and up: `ip link add vcan0 type vcan; ip link set vcan0 up`. The hub's side is a
line that nobody uses, else a shared one. Ctrl-C ends it; a line on stderr then tells how many frames went each way and
how many were lost.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack

from canwire import ChannelMode, Siblings
from canwire.commands.can_line import add_line_arguments, bring_up, wanted_by
from canwire.commands.console import complain
from canwire.commands.shared_hub import connected, find_line

_QUEUE = 32_768


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    add_line_arguments(parser)
    parser.add_argument("interface", metavar="INTERFACE", help="the kernel's: vcan0, can0")


def run(arguments: argparse.Namespace) -> int:
    """Pass frames on until Ctrl-C; HubError without a hub or an interface, OSError once that goes down."""
    from canwire.socketcan.bridge import Bridge, kernel_socket

    with ExitStack() as closing:
        hub = connected(arguments, "bridge", closing)
        kernel = closing.enter_context(kernel_socket(arguments.interface))
        place = find_line(hub, arguments.line, to_send=True)
        channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
        channel.set_up(ChannelMode(receive=_QUEUE, transmit=1024, siblings=Siblings.OTHERS))
        bring_up(hub, place, wanted_by(arguments))
        channel.activate()
        complain(f"{place.address} on {place.info.bus or 'no bus'} and {arguments.interface} are one bus now")
        bridge = Bridge(channel, kernel)
        try:
            bridge.run()
        finally:
            complain(
                f"{bridge.to_kernel} to {arguments.interface}, {bridge.to_hub} from there, {bridge.lost} lost"
            )
    return 0
