"""`canwire lin dump`: what happens on a line."""

from __future__ import annotations

import argparse
from contextlib import ExitStack

from canwire import BadValue
from canwire.commands.console import complain
from canwire.commands.lin.line import Wish, add_lin_arguments, begin_listening, find_lin_line, lin_status_of
from canwire.commands.lin.show import Shown, loaded_network, opened_monitor
from canwire.commands.shared_hub import connected


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_lin_arguments(parser)
    parser.add_argument(
        "--master", action="store_true", help="start a line that nobody started as master, not as slave"
    )
    parser.add_argument("-n", "--count", type=int, metavar="COUNT", help="end after this many lines")
    parser.add_argument("-T", "--timeout", type=float, metavar="SECONDS", help="end after this much silence")
    parser.add_argument("-e", "--errors", action="store_true", help="show errors and state changes as well")
    parser.add_argument("-i", "--bus-name", action="store_true", help="show the bus's name instead of LINE")
    parser.add_argument("--ldf", metavar="FILE", help="show the signals, as this description has them")


def run(arguments: argparse.Namespace) -> int:
    """Print lines until COUNT, silence or Ctrl-C."""
    for option, least in (("count", 1), ("timeout", 0)):
        value = getattr(arguments, option)
        if value is not None and not value >= least:
            raise BadValue(f"--{option} {value}: {least} or more")
    network = loaded_network(arguments.ldf)
    with ExitStack() as closing:
        hub = connected(arguments, "lin dump", closing)
        place = find_lin_line(hub, arguments.line)
        monitor = opened_monitor(hub, place, closing, events=arguments.errors)
        rate = arguments.bit_rate
        if rate is None and network is not None and not lin_status_of(hub, place).running:
            rate = network.bit_rate
        told = begin_listening(hub, place, Wish(arguments.master, rate))
        name = place.info.bus if arguments.bus_name and place.info.bus else arguments.line
        shown = Shown(hub, monitor, name, network)
        try:
            complain(told)
            while arguments.count is None or shown.lines < arguments.count:
                message = monitor.receive(arguments.timeout)
                if message is None:
                    break
                shown.show(message)
        finally:
            complain(shown.summary())
    return 0
