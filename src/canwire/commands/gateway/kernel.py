"""Joins a bus of the hub and a CAN interface of the kernel to one bus."""

from __future__ import annotations

import argparse
from contextlib import ExitStack

from canwire import BadValue, ChannelMode, Hub, Siblings
from canwire.commands.can_line import bring_up, wanted_by
from canwire.commands.console import complain
from canwire.commands.shared_hub import find_line

_QUEUE = 32_768


def join(arguments: argparse.Namespace, hub: Hub, interface: str) -> int:
    """Pass frames on until Ctrl-C. Raises HubError without such an interface, OSError when it goes down."""
    from canwire.socketcan.bridge import Bridge, kernel_socket

    for rule in ("filter", "map", "change", "rate", "one_way"):
        if getattr(arguments, rule):
            option = "--" + rule.replace("_", "-")
            raise BadValue(
                f"{option}: between buses of hubs only; everything passes between a bus and the kernel"
            )
    with ExitStack() as closing:
        kernel = closing.enter_context(kernel_socket(interface))
        place = find_line(hub, arguments.line, to_send=True)
        channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
        channel.set_up(ChannelMode(receive=_QUEUE, transmit=1024, siblings=Siblings.OTHERS))
        bring_up(hub, place, wanted_by(arguments))
        channel.activate()
        complain(f"{place.address} on {place.info.bus or 'no bus'} and {interface} are one bus now")
        bridge = Bridge(channel, kernel)
        try:
            bridge.run()
        finally:
            complain(f"{bridge.to_kernel} to {interface}, {bridge.to_hub} from there, {bridge.lost} lost")
    return 0
