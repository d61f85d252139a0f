"""`canwire router`: a router that hubs and programs connect to, where they cannot reach each other.

canwire router --listen tcp/10.0.0.7:7447 --access lab.toml    the users in that file, and hubs by its [router]
canwire offer --via tcp/10.0.0.7:7447 --access lab.toml        on the bench
canwire dump can0 --hub zenoh://canwire/bench1?via=tcp/10.0.0.7:7447

It asks everybody who they are, and nobody can use another one's name. One line says that it listens; it ends by
SIGTERM, SIGHUP or Ctrl-C. Needs canwire[network].
"""

from __future__ import annotations

import argparse

import canwire
from canwire.commands.shell.ending import signals_call


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    parser.add_argument(
        "--listen",
        action="append",
        required=True,
        metavar="ENDPOINT",
        help="tcp/ADDRESS:PORT or tls/ADDRESS:PORT; several times for several",
    )
    parser.add_argument(
        "--access", required=True, metavar="FILE", help="the file of users that the hubs have (TOML)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Route until SIGTERM, SIGHUP or SIGINT."""
    stop = canwire.Event(manual_reset=True)
    where = ", ".join(arguments.listen)
    try:
        with signals_call(stop.set):
            canwire.route(
                arguments.listen,
                arguments.access,
                ready=lambda: print(f"router on {where}", flush=True),
                stop=stop,
            )
    finally:
        stop.close()
    return 0
