"""`canwire serve`: a hub in the foreground; any number of programs then share its boards.

canwire serve                                   on this user's default socket, which canwire.connect() uses
canwire serve --socket ./bench --time fast      on this socket; the buses do not wait for the clock
canwire serve --config canwire.toml             these buses and boards
canwire serve --time lockstep --programs 5      one virtual time for five programs, each started with CANWIRE_TIMED=1
canwire serve --dongle                          with a CANBUS dongle on a pseudo terminal
canwire serve --socketcand                      for Kayak, SavvyCAN and python-can's socketcand, too
canwire serve --network                         offered to other machines, too (see canwire offer)

A line on stdout reports that the hub is ready. Before that, stderr has a line for everything unusual about the buses,
such as a cable that is too long. SIGTERM, SIGHUP and Ctrl-C end it: the
socket is removed, and every client gets HubLost.
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
    """Add the verb's arguments."""
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
        "--socketcand",
        nargs="?",
        const="",
        metavar="HOST:PORT",
        help="serve socketcand's protocol, too (default: 127.0.0.1:29536)",
    )
    parser.add_argument(
        "--programs",
        type=_programs,
        metavar="N|NAMES",
        help="lockstep: time begins once so many programs take part, or all of these (a,b,c: in this order)",
    )
    parser.add_argument(
        "--patience",
        type=float,
        metavar="SECONDS",
        help="lockstep: name a program that computes for longer (default: 5)",
    )
    parser.add_argument(
        "--pace",
        type=float,
        metavar="FACTOR",
        help="lockstep: held to the wall clock, 1: as quickly, 0.1: a tenth (see canwire pace)",
    )
    parser.add_argument(
        "--network", action="store_true", help="offer it to other machines, too, with the options below"
    )
    add_offer_arguments(parser.add_argument_group("with --network"))
    add_time_argument(
        parser, ("real", "fast", "lockstep"), "programs that share a hub wait for each other by the clock"
    )


def run(arguments: argparse.Namespace) -> int:
    """Serve until SIGTERM, SIGHUP or SIGINT."""
    time = arguments.time or "real"
    if time != "lockstep" and (arguments.programs, arguments.patience, arguments.pace) != (None, None, None):
        raise BadValue("--programs, --patience and --pace are for --time lockstep")
    if given(arguments) and not arguments.network:
        raise BadValue("these options say how a hub is offered to other machines: give --network, too")
    stop = canwire.Event(manual_reset=True)

    def end() -> None:
        _tell_systemd("STOPPING=1")
        stop.set()

    beside = contextlib.ExitStack()

    def ready(introduction: str) -> None:
        if arguments.network:
            said = beside.enter_context(offering(arguments, usual_hub(arguments.socket), stop))
            introduction += f", {said}"
        _ready(introduction)
        if arguments.dongle is not None:
            beside.enter_context(_dongle(arguments.dongle, arguments.socket))
        if arguments.socketcand is not None:
            listen = ["--listen", arguments.socketcand] * bool(arguments.socketcand)
            beside.enter_context(_verb("socketcand", "--beside", *listen, hub=arguments.socket))

    gc.disable()  # until the boards are there: thousands of them would be looked at again and again
    try:
        with signals_call(end):
            canwire.serve(
                arguments.socket,
                arguments.config,
                time,
                programs=1 if arguments.programs is None else arguments.programs,
                patience_s=5.0 if arguments.patience is None else arguments.patience,
                pace=arguments.pace,
                ready=ready,
                stop=stop,
                warn=complain,
            )
    finally:
        gc.enable()
        beside.close()
        stop.close()
    return 0


def _programs(text: str) -> int | list[str]:
    """Return the number of programs, or their names."""
    names = [name.strip() for name in text.split(",")]
    if len(names) == 1 and names[0].isdecimal() and int(names[0]) > 0:
        return int(names[0])
    if not all(names) or len(set(names)) < len(names) or names[0].lstrip("-").isdecimal():
        raise argparse.ArgumentTypeError(
            f"{text!r}: a number from 1 up, or different names with commas between them"
        )
    return names


def _ready(introduction: str) -> None:
    # what is there now stays: the collector need not look at it again, which takes milliseconds
    gc.collect()
    gc.freeze()
    gc.enable()
    print(introduction, flush=True)
    _tell_systemd("READY=1")


def _dongle(link: str, address: str | None) -> contextlib.AbstractContextManager[None]:
    link = os.path.expanduser(link) if link else os.path.join(canwire.state_directory(), USUAL_LINK)
    return _verb("slcan", "--pty", link, hub=address)


@contextlib.contextmanager
def _verb(name: str, *words: str, hub: str | None) -> Iterator[None]:
    """Run a verb in a separate process, so that its work takes no time from the buses; end it on exit."""
    address = hub or canwire.default_address()
    with subprocess.Popen([sys.executable, "-m", "canwire", name, *words, "--hub", address]) as process:
        yield
        process.terminate()


def _tell_systemd(what: str) -> None:
    """Send this state to systemd by sd_notify(3), if NOTIFY_SOCKET is set."""
    address = os.environ.get("NOTIFY_SOCKET")
    if address:
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notifier:
            notifier.sendto(what.encode(), address.replace("@", "\0", 1) if address[0] == "@" else address)
