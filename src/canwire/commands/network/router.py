"""`canwire router`: route between hubs and programs that cannot reach each other.

canwire router --listen tcp/10.0.0.7:7447 --access lab.toml    users and hubs ([router]) of that file
canwire offer --via tcp/10.0.0.7:7447 --access lab.toml        on the bench
canwire dump can0 --hub zenoh://canwire/bench1?via=tcp/10.0.0.7:7447

Every hub and program must authenticate, and cannot use the name of another. The router prints a line when it listens;
it ends at SIGTERM, SIGHUP or Ctrl-C. Needs canwire[network].
"""

from __future__ import annotations

import argparse

import canwire
from canwire.commands.shell.ending import signals_call


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "--listen",
        action="append",
        required=True,
        metavar="ENDPOINT",
        help="listen at tcp/ADDRESS:PORT or tls/ADDRESS:PORT; may be given several times",
    )
    parser.add_argument(
        "--access", required=True, metavar="FILE", help="file of users, the same as for the hubs (TOML)"
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
