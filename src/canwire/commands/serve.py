"""`canwire serve`: a hub in the foreground; any number of programs then share its boards.

canwire serve                                   on this user's usual socket, where canwire.connect() looks
canwire serve --socket ./bench --time fast      on a socket of its own; the buses do not wait for the clock
canwire serve --config canwire.toml             these buses and boards
canwire serve --dongle                          with a CANBUS dongle on a pseudo terminal
canwire serve --network                         offered to other machines, too (see canwire offer)

One line says when it is ready; before that, stderr has a line for everything unusual about the buses, such as a cable
that is too long. SIGTERM, SIGHUP and Ctrl-C end it: the socket is removed, and every client gets HubLost.
Without --config: the file that CANWIRE_CONFIG names, else ./canwire.toml if there is one, else a default.
Under systemd (Type=notify) it reports when it is ready and when it stops.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import os
import socket
import subprocess
import sys
from collections.abc import Iterator

import canwire
from canwire import BadValue
from canwire.commands.console import complain
from canwire.commands.network.beside import offering, usual_hub
from canwire.commands.network.options import add_offer_arguments, given
from canwire.commands.shell.ending import signals_call
from canwire.commands.shell.parser import add_time_argument

USUAL_LINK = "ttyCANBUS0"  # in canwire.state_directory()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    parser.add_argument(
        "--socket",
        "--hub",
        metavar="PATH",
        help="listen here; default: this user's usual socket",
    )
    parser.add_argument("--config", metavar="FILE", help="buses and boards; default: ./canwire.toml, if any")
    parser.add_argument(
        "--dongle",
        nargs="?",
        const="",
        metavar="LINK",
        help=f"plug in a CANBUS dongle, too, found by this link (default: {USUAL_LINK} where canwire slcan has it)",
    )
    parser.add_argument(
        "--network", action="store_true", help="offer it to other machines, too, with the options below"
    )
    add_offer_arguments(parser.add_argument_group("with --network"))
    add_time_argument(parser, ("real", "fast"), "programs that share a hub wait for each other by the clock")


def run(arguments: argparse.Namespace) -> int:
    """Serve until SIGTERM, SIGHUP or SIGINT."""
    if given(arguments) and not arguments.network:
        raise BadValue("these options say how a hub is offered to other machines: give --network, too")
    stop = canwire.Event(manual_reset=True)

    def end() -> None:
        _tell_systemd("STOPPING=1")
        stop.set()

    beside = contextlib.ExitStack()

    def ready(introduction: str) -> None:
        if arguments.network:
            said = beside.enter_context(offering(arguments, usual_hub(arguments.socket)))
            introduction += f", {said}"
        _ready(introduction)
        if arguments.dongle is not None:
            beside.enter_context(_dongle(arguments.dongle, arguments.socket))

    try:
        with signals_call(end):
            canwire.serve(
                arguments.socket,
                arguments.config,
                arguments.time or "real",
                ready=ready,
                stop=stop,
                warn=complain,
            )
    finally:
        beside.close()
        stop.close()
    return 0


def _ready(introduction: str) -> None:
    # what is there now stays: the collector need not look at it again, which takes milliseconds
    gc.collect()
    gc.freeze()
    print(introduction, flush=True)
    _tell_systemd("READY=1")


@contextlib.contextmanager
def _dongle(link: str, address: str | None) -> Iterator[None]:
    """A process of its own serves it: what it parses takes no time from the buses."""
    hub = address or canwire.default_address()
    link = os.path.expanduser(link) if link else os.path.join(canwire.state_directory(), USUAL_LINK)
    command = [sys.executable, "-m", "canwire", "slcan", "--pty", link, "--hub", hub]
    with subprocess.Popen(command) as process:
        yield
        process.terminate()


def _tell_systemd(what: str) -> None:
    """sd_notify(3), where systemd has asked for it."""
    address = os.environ.get("NOTIFY_SOCKET")
    if address:
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notifier:
            notifier.sendto(what.encode(), address.replace("@", "\0", 1) if address[0] == "@" else address)
