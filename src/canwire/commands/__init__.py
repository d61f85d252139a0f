"""The `canwire` command: one verb per file, loaded when it is called for.

A verb's module has two functions, `add_arguments(parser)` and `run(arguments) -> int`; the table
below names it. Exit status: what `run` returns; 2 for a mistake, one line on stderr; 130 after Ctrl-C, 143 after
SIGTERM, 129 after SIGHUP (but for verbs whose regular end these are); 141 when the reader of the output has gone.
"""

from __future__ import annotations

import argparse
import gc
import importlib
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from canwire.commands.shell.ending import (
    FAILED,
    GONE,
    ended_by,
    forget_output,
    have_streams,
    is_full,
    signals_raise,
)
from canwire.commands.shell.outside_imports import signals_outside_imports
from canwire.commands.shell.parser import Help, Parser


class Verb(NamedTuple):
    """The module of a verb, and its line in --help."""

    module: str
    help: str


VERBS = {
    "play": Verb("canwire.commands.play", "send the frames of a log, at their times"),
    "record": Verb("canwire.commands.logs.record", "write what happens on a line of the hub to log files"),
    "convert": Verb("canwire.commands.logs.convert", "write a log in another format"),
    "stats": Verb("canwire.commands.stats.verb", "show what is in a log: identifiers, periods, errors, load"),
    "plot": Verb("canwire.commands.plot.verb", "draw signals of a log, or of a line of the hub"),
    "decode": Verb("canwire.commands.databases.decode", "show a log by a database: names and signals"),
    "db": Verb("canwire.commands.databases.look", "show what a database says: messages, signals, bits"),
    "query": Verb("canwire.commands.query.verb", "ask a log by SQL, signals too, however big it is"),
    "demo": Verb("canwire.commands.demo", "show a small bus at work"),
    "devices": Verb("canwire.commands.devices.verb", "list the boards of the hub and who uses them"),
    "plug": Verb("canwire.commands.plug", "put a board into the hub"),
    "share": Verb("canwire.commands.share", "share real adapters with every program through the hub"),
    "adapters": Verb(
        "canwire.commands.devices.adapters", "list this machine's real adapters, and how to share them"
    ),
    "unplug": Verb("canwire.commands.unplug", "pull a board out of the hub"),
    "registers": Verb("canwire.commands.registers", "show the registers of a board's chip"),
    "up": Verb("canwire.commands.up", "start a line of the hub, and leave it running"),
    "stop": Verb("canwire.commands.stop", "take a line of the hub off its bus"),
    "dump": Verb("canwire.commands.dump.verb", "show what happens on a line of the hub"),
    "send": Verb("canwire.commands.send", "send frames from a line of the hub"),
    "simulate": Verb(
        "canwire.commands.databases.simulate", "send a node's messages at their cycle times, by a DBC file"
    ),
    "gen": Verb("canwire.commands.gen.verb", "generate traffic on a line of the hub"),
    "load": Verb("canwire.commands.live.load", "show how busy the buses of the hub are"),
    "view": Verb("canwire.commands.view.verb", "show a line of the hub as a table, one row per identifier"),
    "detect": Verb("canwire.commands.live.detect", "find the bit rate of a bus, only listening"),
    "doctor": Verb("canwire.commands.doctor.verb", "find what keeps canwire from working, and how to fix it"),
    "recover": Verb("canwire.commands.recover", "have a line of the hub begin again after bus-off"),
    "lin": Verb("canwire.commands.lin.verb", "watch a LIN line of the hub, send from one, run a schedule"),
    "isotp": Verb(
        "canwire.commands.transport.isotp", "send, receive and watch messages longer than a frame (ISO-TP)"
    ),
    "uds": Verb(
        "canwire.commands.transport.uds", "ask an ECU by UDS: read, write, sessions, faults, routines, flash"
    ),
    "acan": Verb(
        "canwire.commands.acan.verb", "CANTERM, WCT and CANSPY of INduCAN104 boards, and their driver's setup"
    ),
    "candrv": Verb(
        "canwire.commands.candrv.verb",
        "CanTestSuite of F&S boards, the registry of their driver, devices as terminals",
    ),
    "fault": Verb("canwire.commands.fault.verb", "inject a fault into a bus of the hub"),
    "campaign": Verb("canwire.commands.campaign.verb", "play a function with a lab thousands of times"),
    "bits": Verb("canwire.commands.bits", "show a frame bit by bit, as on the wire"),
    "timing": Verb(
        "canwire.commands.timing.verb", "calculate bit timings, and whether nodes understand each other"
    ),
    "run": Verb("canwire.commands.socketcan.run", "run a program that speaks SocketCAN on buses of the hub"),
    "bridge": Verb(
        "canwire.commands.gateway.verb", "pass frames on between two buses, or a bus and the kernel's"
    ),
    "socketcand": Verb(
        "canwire.commands.socketcan.socketcand",
        "serve buses of the hub to programs that speak socketcand's protocol",
    ),
    "native": Verb("canwire.commands.native", "tell a build where headers and libraries for C and C++ are"),
    "slcan": Verb(
        "canwire.commands.slcan", "play a CANBUS dongle, for programs that use serial CAN adapters"
    ),
    "web": Verb("canwire.commands.web.verb", "show the hub's boards and traffic in a browser"),
    "serve": Verb("canwire.commands.serve", "share boards among programs, on a socket"),
    "pace": Verb("canwire.commands.pace", "show or set how quickly a lockstep hub's time passes"),
    "offer": Verb("canwire.commands.network.offer", "offer the hub to other machines"),
    "relay": Verb("canwire.commands.network.relay", "send frames once to all programs of this machine"),
    "router": Verb("canwire.commands.network.router", "join hubs and programs that cannot reach each other"),
    "completion": Verb("canwire.commands.shell.completion", "completion of verbs and options for a shell"),
}


GROUPS = {
    "start here": "demo serve devices web doctor",
    "look": "dump view load stats plot detect registers bits timing",
    "send": "send gen simulate play lin isotp uds",
    "files": "record convert query decode db",
    "faults": "fault recover campaign",
    "lines and boards": "up stop plug unplug share adapters",
    "machines": "offer relay router pace",
    "interfaces": "run bridge socketcand slcan native acan candrv completion",
}
"""Every verb once, as `canwire` and `canwire --help` show them."""
_BY_ITSELF = """canwire puts CAN, CAN FD and LIN buses that behave like copper on this computer.

  canwire demo              see a small bus at work; nothing else is needed
  canwire serve             share boards among programs: leave it running in a separate terminal
  canwire dump can0         what happens on the bus can0
  canwire send can0 123#11  a frame from another terminal

"""


def _shown_by_itself() -> str:
    """The text that `canwire` without a verb prints."""
    width = max(map(len, GROUPS))
    rows = "".join(f"  {title:<{width}}  {verbs.replace(' ', ', ')}\n" for title, verbs in GROUPS.items())
    return f"{_BY_ITSELF}{rows}\n`canwire --help` says what each verb does, `canwire VERB --help` how it is used.\n"


def _shown_by_group() -> str:
    """Every verb with what it does."""
    width = max(map(len, VERBS))
    return "\n".join(
        f"{title}:\n" + "".join(f"  {verb:<{width}}  {VERBS[verb].help}\n" for verb in verbs.split())
        for title, verbs in GROUPS.items()
    )


class _ShowVersion(argparse.Action):
    """--version: the package's version and whether its core is compiled."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        import canwire
        from canwire import __version__

        core = "compiled core" if canwire.core_mode() == "compiled" else "uncompiled core: slower"
        print(f"canwire {__version__} ({core})")
        parser.exit()


_NEW_OBJECTS = 10_000  # between two collections; at the usual 700, collecting is a tenth of a verb's start


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line, sys.argv's by default; returns the exit status. argparse exits by itself (SystemExit)."""
    if argv is None:
        gc.set_threshold(_NEW_OBJECTS)
    words = list(sys.argv[1:] if argv is None else argv)
    have_streams()
    try:
        with signals_raise():
            try:
                return signals_outside_imports(lambda: _run(words))
            finally:
                sys.stdout.flush()
    except BrokenPipeError:
        forget_output()
        return GONE
    except KeyboardInterrupt as error:
        return ended_by(error)
    except OSError as error:  # files have a name: this is what print writes to
        forget_output()
        with suppress(OSError):  # it may be this that is full
            print(f"canwire: standard output: {error.strerror}", file=sys.stderr)
        return FAILED
    finally:
        # the process ends, and what is left in circles with it; but nanobind, DuckDB's, complains of what is left
        if argv is None and "duckdb" not in sys.modules:
            gc.freeze()


def _run(words: list[str]) -> int:
    from canwire import CanwireError, signals_end_waits

    if not words and "_ARGCOMPLETE" not in os.environ:
        print(_shown_by_itself(), end="")
        return FAILED
    parser = Parser(
        prog="canwire", description="CAN, CAN FD and LIN buses that behave like copper.", formatter_class=Help
    )
    parser.add_argument("--version", nargs=0, action=_ShowVersion, help="print the version and exit")
    parser.epilog = _shown_by_group()
    verbs = parser.add_subparsers(metavar="verb", required=True, prog="canwire")
    if words[:1] == ["help"]:  # `canwire help dump` is `canwire dump --help`
        words = [*words[1:], "--help"]
    asked = os.environ.get("COMP_LINE", "").split()[1:] if "_ARGCOMPLETE" in os.environ else words
    called = next((word for word in asked if word in VERBS), None)
    # where the verb is plain the others have no parsers, which take as long as its own work, and are never loaded
    offered = {called: VERBS[called]} if called is not None and words[:1] == [called] else VERBS
    for name, verb in offered.items():
        sub = verbs.add_parser(name, description=verb.help, formatter_class=Help)
        if name == called:
            _load(verb, sub)
    if "_ARGCOMPLETE" in os.environ:
        from canwire.commands.shell.completion import answer

        answer(parser)
    arguments = parser.parse_args(words)
    try:
        with signals_end_waits():
            return int(arguments.run(arguments))
    except (CanwireError, OSError) as error:
        if isinstance(error, BrokenPipeError) or is_full(error):
            raise
        print(f"canwire: {error}", file=sys.stderr)
        return FAILED


def _load(verb: Verb, parser: argparse.ArgumentParser) -> None:
    """Its arguments, and in --help what its module says of itself, examples included."""
    module = importlib.import_module(verb.module)
    parser.description = (module.__doc__ or verb.help).strip()
    module.add_arguments(parser)
    parser.set_defaults(run=module.run)
