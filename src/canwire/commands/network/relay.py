"""`canwire relay`: send what several programs of this machine receive from a hub over the network only once.

canwire offer --listen tcp/192.168.1.5:7449 --relay tcp/192.168.1.5:7450 --access lab.toml    on the bench
canwire relay tcp/192.168.1.5:7450                                                           on this machine
canwire dump can0 --hub zenoh://canwire/bench1?relay=tcp/127.0.0.1:7448                      each program here

It prints a line with the address for programs, and lines about breaks of its connection, which it makes again by
itself. Each program identifies itself to the hub as without a relay. It ends at SIGTERM, SIGHUP or Ctrl-C.
"""

from __future__ import annotations

import argparse

import canwire
from canwire.commands.console import complain
from canwire.commands.shell.ending import signals_call


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("endpoint", metavar="ENDPOINT", help="where the hub listens for relays")
    parser.add_argument(
        "--listen",
        default="tcp/127.0.0.1:7448",
        metavar="ENDPOINT",
        help="where programs of this machine connect (default: tcp/127.0.0.1:7448)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Relay until SIGTERM, SIGHUP or SIGINT."""
    stop = canwire.Event(manual_reset=True)
    try:
        with signals_call(stop.set):
            canwire.relay(
                arguments.endpoint,
                listen=arguments.listen,
                ready=lambda address: print(f"relayed as {address}", flush=True),
                stop=stop,
                warn=complain,
            )
    finally:
        stop.close()
    return 0
