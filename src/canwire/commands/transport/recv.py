"""`canwire isotp recv`."""

from __future__ import annotations

import argparse
from contextlib import ExitStack

from canwire.commands.console import complain
from canwire.commands.shared_hub import connected
from canwire.commands.transport.line import IsoTpLine, add_transport_arguments

_TURN_S = 0.2  # between two looks at what went wrong


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the sub-verb's arguments."""
    add_transport_arguments(parser, tx="7E8", rx="7E0")
    parser.add_argument("-n", "--count", type=int, metavar="COUNT", help="end after this many messages")


def run(arguments: argparse.Namespace) -> int:
    """Print messages until COUNT, or Ctrl-C."""
    with ExitStack() as closing:
        line = IsoTpLine(connected(arguments, "isotp", closing), arguments, closing)
        complain(f"{line.place.address}: receiving {arguments.rx}, flow control by {arguments.tx}")
        count = told = 0
        while arguments.count is None or count < arguments.count:
            message = line.layer.recv(block=True, timeout=_TURN_S)
            for error in line.errors[told:]:
                complain(str(error))
            told = len(line.errors)
            line.channel.check()
            if message is not None:
                count += 1
                print(bytes(message).hex().upper(), flush=True)
    return 0
