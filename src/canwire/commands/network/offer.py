"""`canwire offer`: offer the running hub to other machines, as zenoh://REALM/NAME.

canwire offer                                                 on the loopback address of this machine only
canwire offer --listen tcp/192.168.1.5:7449 --access lab.toml  to the users in that file
canwire offer --listen tcp/0.0.0.0:7449 --insecure            to all who can reach this machine

It prints a line with the address, for `canwire dump can0 --hub zenoh://canwire/NAME` or for CANWIRE_HUB. It ends with
the hub, or at SIGTERM, SIGHUP or Ctrl-C. `canwire serve --network` starts a hub and offers it. Needs canwire[network].
"""

from __future__ import annotations

import argparse

import canwire
from canwire.commands.console import complain
from canwire.commands.network.options import add_offer_arguments
from canwire.commands.shared_hub import add_hub_argument
from canwire.commands.shell.ending import signals_call


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_hub_argument(parser)
    add_offer_arguments(parser)
    parser.add_argument(
        "--beside", action="store_true", help=argparse.SUPPRESS
    )  # the hub's own: ends with it


def run(arguments: argparse.Namespace) -> int:
    """Offer the hub until SIGTERM, SIGHUP or SIGINT."""
    stop = canwire.Event(manual_reset=True)
    said: list[str] = []

    def ready(address: str) -> None:
        said.append(address)
        print(f"offered as {address}", flush=True)

    try:
        with signals_call(stop.set):
            canwire.offer(
                arguments.hub,
                realm=arguments.realm or "canwire",
                name=arguments.name,
                listen=arguments.listen or (),
                via=arguments.via or (),
                relay=arguments.relay or (),
                access=arguments.access,
                insecure=arguments.insecure,
                age_s=2.0 if arguments.age is None else float(arguments.age),
                silence_s=30.0 if arguments.silence is None else float(arguments.silence),
                ready=ready,
                stop=stop,
                warn=complain,
            )
    except canwire.HubLost:
        if not (said and arguments.beside):
            raise
    finally:
        stop.close()
    return 0
