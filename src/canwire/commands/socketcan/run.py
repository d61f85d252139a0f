"""`canwire run`: run a program that uses SocketCAN, with the buses of the hub as its CAN interfaces.

canwire run candump any                             show every bus of the hub
canwire run cangen can0                             use a free line on can0, else share one
canwire run cansend HW000001_0 123#DEADBEEF         line 0 of the board HW000001
canwire run --interface vcan0=can0 -- ./test.sh     can0 under the name that a script expects
canwire run sh                                      a shell, for all programs started in it

It needs neither CAN in the kernel nor special rights. The process becomes the program: it receives the signals and sets
the exit status. On an interface named after a bus, frames are always acknowledged, as on the kernel's vcan. For
programs that make system calls directly (static ones, Go) canwire intercepts the calls with seccomp if that is allowed,
else it refuses the program. See docs/socketcan.md.
"""

from __future__ import annotations

import argparse
import os
import shutil
from collections.abc import Callable
from contextlib import ExitStack

from canwire import BadValue, epoch_ns
from canwire.commands.can_line import add_rate_arguments, wanted_by
from canwire.commands.console import complain
from canwire.commands.shared_hub import connected
from canwire.commands.socketcan.options import add_interface_argument, mappings_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_interface_argument(parser)
    add_rate_arguments(parser)
    parser.add_argument(
        "program", nargs=argparse.REMAINDER, metavar="PROGRAM [ARGUMENT ...]", help="what to run"
    )


def run(arguments: argparse.Namespace) -> int:
    """Replace this process by the program. Raises HubError without a hub, BadValue, Unsupported without the shim."""
    from canwire.socketcan.launch import launch, shim
    from canwire.socketcan.programs import calls_itself, trouble_with

    words = arguments.program[1:] if arguments.program[:1] == ["--"] else arguments.program
    if not words:
        raise BadValue("no program to run; `canwire run candump any` shows every bus")
    arguments.words = words
    shim()  # says so first where there is none, on Windows
    path = shutil.which(words[0])
    if path is None:
        raise BadValue(f"{words[0]}: no such program")
    supervised = calls_itself(path)
    if not supervised and (trouble := trouble_with(path)):
        complain(f"{path} {trouble}; it has no CAN")
    mappings = mappings_of(arguments)

    def serving(directory: str, programs: tuple[int, int], ready: Callable[[], object]) -> None:
        _serve(arguments, mappings, directory, programs, ready)

    launch(words[0], words[1:], serving, complain, supervised=supervised)
    return 0


def _serve(
    arguments: argparse.Namespace,
    mappings: dict[str, str],
    directory: str,
    programs: tuple[int, int],
    ready: Callable[[], object],
) -> None:
    from canwire.socketcan.launch import shim
    from canwire.socketcan.server import Server

    with ExitStack() as closing:
        hub = connected(arguments, "run", closing)
        if os.environ.get("CANWIRE_TIMED") == "1":
            hub.keep_time(os.environ.get("CANWIRE_NAME") or os.path.basename(arguments.words[0]))
        server = Server(hub, directory, shim(), mappings, wanted_by(arguments), epoch_ns(hub), complain)
        ready()
        server.run(programs)
