"""`canwire socketcand`: serve the buses of the hub over TCP as socketcand does, for Kayak, SavvyCAN and python-can.

canwire socketcand                                     on 127.0.0.1:29536, for programs on this machine
canwire socketcand --listen 0.0.0.0:29536              for all who can reach this machine
canwire socketcand --listen ./socketcand.sock          on a Unix socket, for this user alone
canwire socketcand --interface vcan0=can0              can0 under another name
canwire socketcand --beacon 192.168.0.255              announce the server to this network every two seconds

The protocol has no passwords: every client that can reach the port may send on every bus. A client that does not read
loses frames, which are counted; a client that sends more than its bus can carry is read more slowly.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack, closing

import canwire
from canwire import HubLost, epoch_ns
from canwire.commands.can_line import add_rate_arguments, wanted_by
from canwire.commands.console import complain
from canwire.commands.greeting import add_greeting_argument
from canwire.commands.reconnecting import add_reconnect_argument, going_on
from canwire.commands.shared_hub import connected
from canwire.commands.shell.ending import signals_call
from canwire.commands.socketcan.options import add_interface_argument, mappings_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "--listen",
        default="",
        metavar="HOST:PORT|PATH",
        help="listen there (default: 127.0.0.1:29536); a path is a Unix socket, @NAME an abstract one",
    )
    parser.add_argument(
        "--beacon",
        default="",
        metavar="ADDRESS",
        help="announce the server at this address by UDP, port 42000",
    )
    parser.add_argument(
        "--beside", action="store_true", help=argparse.SUPPRESS
    )  # the hub's own: ends with it
    add_greeting_argument(parser, "opened a bus")
    add_reconnect_argument(parser)
    add_interface_argument(parser)
    add_rate_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Serve until SIGTERM, SIGHUP, SIGINT. Raises HubLost when the hub ends, HubError without one, OSError."""
    return going_on(arguments, _serve)


def _serve(arguments: argparse.Namespace) -> int:
    from canwire.socketcan.daemon.daemon import Daemon
    from canwire.socketcan.daemon.listening import parse_address, shown

    with ExitStack() as stack:
        hub = connected(arguments, "socketcand", stack)
        stop = stack.enter_context(closing(canwire.Event(manual_reset=True)))
        daemon = Daemon(
            hub,
            parse_address(arguments.listen),
            wanted_by(arguments),
            epoch_ns(hub),
            complain,
            mappings=mappings_of(arguments),
            beacon=arguments.beacon,
            greeting_s=arguments.greeting_seconds,
        )
        with signals_call(stop.set):
            print(f"socketcand on {shown(daemon.address)}", flush=True)
            daemon.run(stop)
        if hub.lost and not arguments.beside:
            raise HubLost("the hub is gone, and so is what socketcand served of it")
    return 0
