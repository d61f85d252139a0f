"""`canwire socketcand`: serve the hub's buses over TCP as socketcand does, for Kayak, SavvyCAN and python-can.

canwire socketcand                                     on 127.0.0.1:29536, for programs of this machine
canwire socketcand --listen 0.0.0.0:29536              for everybody who reaches this machine
canwire socketcand --interface vcan0=can0              can0 under another name
canwire socketcand --beacon 192.168.0.255              and tell this network where it is, every two seconds

The protocol knows no passwords: whoever reaches the port may send on every bus. Linux only. A client that does not read
loses frames, which are counted; one that sends more than its bus carries is read more slowly.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack, closing

import canwire
from canwire import WantedMode
from canwire.commands.console import complain
from canwire.commands.shared_hub import add_hub_argument, add_rate_argument, connected
from canwire.commands.shell.ending import signals_call
from canwire.commands.wall_clock import epoch_ns


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    parser.add_argument("--listen", default="", metavar="HOST:PORT", help="default: 127.0.0.1:29536")
    parser.add_argument(
        "--beacon", default="", metavar="ADDRESS", help="announce it there by UDP, port 42000"
    )
    parser.add_argument(
        "--interface",
        action="append",
        default=[],
        metavar="NAME=LINE",
        help="another name for a bus or a line",
    )
    add_rate_argument(parser, "--bit-rate", "for a line that nobody started", WantedMode.USUAL_BIT_RATE)
    add_rate_argument(parser, "--data-bit-rate", "likewise, CAN FD", WantedMode.USUAL_DATA_BIT_RATE)
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Serve until SIGTERM, SIGHUP, SIGINT, or the hub's end; HubError without a hub, OSError for a port in use."""
    from canwire.socketcan.daemon.daemon import Daemon, parse_address
    from canwire.socketcan.interfaces import parse_mapping

    with ExitStack() as stack:
        hub = connected(arguments, "socketcand", stack)
        stop = stack.enter_context(closing(canwire.Event(manual_reset=True)))
        daemon = Daemon(
            hub,
            parse_address(arguments.listen),
            WantedMode(arguments.bit_rate, arguments.data_bit_rate),
            epoch_ns(hub),
            complain,
            mappings=dict(parse_mapping(text) for text in arguments.interface),
            beacon=arguments.beacon,
        )
        with signals_call(stop.set):
            print(f"socketcand on {daemon.address[0]}:{daemon.address[1]}", flush=True)
            daemon.run(stop)
    return 0
