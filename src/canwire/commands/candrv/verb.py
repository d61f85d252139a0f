"""`canwire candrv`: CanTestSuite of the CANDRV manual, the driver's registry, and CID1: as a terminal.

canwire candrv write -d CID1: -b 500000 -f log   CanWrite: 1000 messages with increasing identifiers
canwire candrv read                              CanRead: every event as ReadFile gives it
canwire candrv send -n 10000 -c 3 -t 2           CanSend: stress the driver, with totals
canwire candrv mon -f log                        CanMon: every event of the binary interface, one a line
canwire candrv install                           register CID1: with the manual's defaults; `remove CID1:`
canwire candrv registry set CID1: Baudrate 500000   also list, get, delete, defaults, import board.reg
canwire candrv active                            which drivers are loaded, with what, on which port
canwire candrv restart CID1:                     reload the driver with the registry's present values
canwire candrv attach CID1: /tmp/can             `echo "731 0 4 11 22 33 44" > /tmp/can` sends, `cat /tmp/can` shows

The programs take the manual's switches (-h or -? shows them) and --hub, and exit with its codes: 0 success, 1 the
device is not there or fails, 2 wrong switches. Devices are [candrv.CID1] in CANWIRE_CONFIG's file, or canwire.toml
here.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from pathlib import Path

from canwire.commands.candrv import registry, suite
from canwire.commands.shared_hub import add_hub_argument, connected

_DEVICE = "CID1:"
_CONFIG = "the file with [candrv.CID1] (default: CANWIRE_CONFIG, or canwire.toml here)"
_NO_OPTIONS = "\0"  # prefix of no option: a program parses its switches itself, as the manual's do


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.description = __doc__
    verbs = parser.add_subparsers(metavar="program", required=True)
    for name, program in suite.PROGRAMS.items():
        sub = verbs.add_parser(name, help=program.help, add_help=False, prefix_chars=_NO_OPTIONS)
        sub.add_argument("words", nargs=argparse.REMAINDER)
        sub.set_defaults(candrv_verb=suite.run, candrv_program=program)
    for name, what in (
        ("install", "register a device with the manual's defaults"),
        ("remove", "unregister it"),
    ):
        sub = verbs.add_parser(name, help=what, description=what)
        sub.add_argument("device", nargs="?", default=_DEVICE, help=f"its name (default: {_DEVICE})")
        _add_config(sub)
        sub.set_defaults(candrv_verb=getattr(registry, name))
    _add_registry(verbs.add_parser("registry", help="what devices are started with"))
    _add_restart(
        verbs.add_parser("restart", help="reload a device's driver with the registry's present values")
    )
    _add_active(
        verbs.add_parser("active", help="which drivers are loaded, with what, on which port of which board")
    )
    _add_attach(verbs.add_parser("attach", help="a device as a terminal, for echo and cat"))


def run(arguments: argparse.Namespace) -> int:
    """The program's exit status; BadValue, BadConfig, NoSuchBoard, HubError for what cannot be."""
    return int(arguments.candrv_verb(arguments))


def _add_config(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--config", type=Path, metavar="FILE", help=_CONFIG)


def _add_registry(parser: argparse.ArgumentParser) -> None:
    parser.description = "What devices are started with: the entries of the manual's chapter 6."
    verbs = parser.add_subparsers(metavar="what", required=True)
    for name, words, help in (
        ("list", "[device]", "all entries of a device, or of all"),
        ("get", "device entry", "the value that counts: the stored one, or the default"),
        ("set", "device entry value", "store a value: decimal, or hex with 0x"),
        ("delete", "device entry", "let the default count"),
        ("defaults", "device", "delete all entries but those that say which device it is"),
        ("import", "file", "store what a .reg file of Windows has for CANDRV's devices"),
    ):
        sub = verbs.add_parser(name, help=help, description=help)
        for word in words.split():
            optional = "?" if word.startswith("[") else None
            sub.add_argument(word.strip("[]"), nargs=optional, metavar=word.strip("[]").upper())
        _add_config(sub)
        sub.set_defaults(candrv_verb=getattr(registry, f"{name}_entries"))


def _add_restart(sub: argparse.ArgumentParser) -> None:
    sub.description = "What a restart of the board does to its driver; nobody may have the device open."
    sub.add_argument("device", nargs="?", default=_DEVICE, help=f"its name (default: {_DEVICE})")
    add_hub_argument(sub)
    sub.set_defaults(candrv_verb=_restart)


def _add_active(sub: argparse.ArgumentParser) -> None:
    sub.description = (
        "What [HKLM\\Drivers\\Active] shows on a board: the drivers that are loaded, each since its device was opened "
        "for the first time, with the entries that count for it until it is restarted."
    )
    add_hub_argument(sub)
    sub.set_defaults(candrv_verb=_active)


def _add_attach(sub: argparse.ArgumentParser) -> None:
    sub.description = (
        "A pseudo terminal at PATH: lines written to it are sent, read from it are events as ReadFile gives them. "
        "Programs may open it one after the other; Ctrl-C or SIGTERM ends it. The registry's acceptance filter counts "
        "if there is one; the default, which lets identifier 0 pass alone, does not."
    )
    sub.add_argument("device", help="its name, like CID1:")
    sub.add_argument(
        "path", type=Path, metavar="PATH", help="where it shall be: a symbolic link is made there"
    )
    add_hub_argument(sub)
    sub.set_defaults(candrv_verb=_attach)


def _restart(arguments: argparse.Namespace) -> int:
    from canwire.candrv import unload

    with ExitStack() as closing:
        unload(connected(arguments, "candrv restart", closing), arguments.device)
    print(f"{arguments.device} is loaded again when it is next opened")
    return 0


def _active(arguments: argparse.Namespace) -> int:
    from canwire.candrv import active
    from canwire.commands.candrv.registry import shown_driver

    with ExitStack() as closing:
        drivers = active(connected(arguments, "candrv active", closing))
    print(
        "\n\n".join(map(shown_driver, drivers))
        or "no driver is loaded: one is when its device is first opened"
    )
    return 0


def _attach(arguments: argparse.Namespace) -> int:
    from canwire.commands.candrv.attach import attach

    return attach(arguments)
