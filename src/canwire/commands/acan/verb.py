"""`canwire acan`: the programs of the INduCAN104 manual, and its driver's installation.

canwire acan install /P:280 /I:5       the driver serves the board at base 280h, IRQ 5; '/I:5*' shares the interrupt
canwire acan install /U                no longer
canwire acan setup 280 5 [DIRECTORY]   START and STOP scripts for that board
canwire acan term [/C:16000] [/R:250] [/I] [/E] [/L] LOCAL REMOTE
                                       CANTERM: what is typed goes to machine REMOTE, what comes is shown
canwire acan wct [/C:16000] [/R:250]   WCT: the same in a window with menus; its settings are in WCT.INI
canwire acan spy                       CANSPY: every message on the bus

Machines are 1 to 7; REMOTE 0 is all of them, LOCAL 0 the number this machine has already. /I sets the controller up
even if it is already, /E shows what is sent, /L sends back what comes. Ctrl-U and Ctrl-T send test patterns, Ctrl-C
ends. CANSPY opens the controller's filters to everything: start it last. The windows of wct and spy need
canwire[tools]; where stdin or stdout is no terminal there are none: plain bytes, plain lines.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from canwire import BadValue
from canwire.commands.acan import programs
from canwire.commands.acan.ini import ini_text
from canwire.commands.shared_hub import add_hub_argument

_TIMEOUT = "once stdin has ended, exit after this much silence; only where stdin or stdout is no terminal"
_SEND = "send this first, written as the trace shows it: '00001001000 - 61 62'"
_BOARD = "this board instead of the installed one: its hardware id or kind"
_DIRECTORY = Path("ACAN")
_INI = Path("WCT.INI")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.description = __doc__
    verbs = parser.add_subparsers(metavar="program", required=True)
    for name, help, words, add, verb in (
        (
            "term",
            "CANTERM",
            "[/C:KHZ] [/R:KBPS] [/I] [/E] [/L] LOCAL REMOTE",
            _term_options,
            programs.term,
        ),
        ("wct", "WCT", "[/C:KHZ] [/R:KBPS]", _wct_options, programs.wct),
        ("spy", "CANSPY", "[/C:KHZ] [/R:KBPS]", _spy_options, programs.spy),
        (
            "install",
            "say which board the driver serves",
            "/P:PORT /I:IRQ[*], or /U",
            _install_options,
            _install,
        ),
        ("setup", "write START and STOP scripts", "PORT IRQ [DIRECTORY]", _no_options, _setup),
    ):
        sub = verbs.add_parser(name, help=help, description=f"{help}: {words}")
        sub.add_argument("words", nargs="*", metavar="WORD", help=words)
        add(sub)
        sub.set_defaults(acan_verb=verb)


def run(arguments: argparse.Namespace) -> int:
    """Run the chosen program. Raises BadValue, NoSuchBoard (no driver), HubError, InUse, ExtraMissing."""
    return int(arguments.acan_verb(arguments))


def _no_options(sub: argparse.ArgumentParser) -> None:
    """Add no options: this program has none."""


def _program_options(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--board", metavar="NAME", help=_BOARD)
    add_hub_argument(sub)


def _term_options(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("-T", "--timeout", type=float, metavar="SECONDS", help=_TIMEOUT)
    _program_options(sub)


def _wct_options(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--ini", type=Path, default=_INI, metavar="FILE", help=f"settings (default: {_INI})")
    _term_options(sub)


def _spy_options(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "-n", "--count", type=int, metavar="COUNT", help="plain lines; end after this many messages"
    )
    sub.add_argument("--send", action="append", default=[], metavar="MESSAGE", help=_SEND)
    sub.add_argument(
        "--redirect", type=Path, metavar="FILE", help="write the trace to the end of that file, too"
    )
    _program_options(sub)


def _install_options(sub: argparse.ArgumentParser) -> None:
    sub.add_argument(
        "--ini", type=Path, metavar="FILE", help="Base= and Irq= of its section [ACAN] say which"
    )
    add_hub_argument(sub)


def _install(arguments: argparse.Namespace) -> int:
    from canwire.acan.install import Installation

    if arguments.ini is not None and arguments.words:
        raise BadValue("give /P: and /I:, or --ini, not both")
    if arguments.ini is not None:
        return programs.install(arguments, Installation.from_ini(ini_text(arguments.ini)))
    return programs.install(arguments, Installation.parse(arguments.words))


def _setup(arguments: argparse.Namespace) -> int:
    from canwire.acan.install import setup

    if len(arguments.words) not in (2, 3):
        raise BadValue("PORT IRQ [DIRECTORY] are needed, as in `canwire acan setup 280 5`")
    port, irq, *rest = arguments.words
    try:
        jumpers = int(port, 16), int(irq)
    except ValueError:
        raise BadValue(f"{port} {irq}: a hexadecimal port and a decimal interrupt, like 280 5") from None
    for path in setup(*jumpers, Path(*rest) if rest else _DIRECTORY):
        print(path)
    return 0
