"""`canwire lin schedule`: slot after slot from a line as its master."""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import BadValue, parse_lin_schedule
from canwire.commands.console import complain
from canwire.commands.lin.line import (
    add_lin_arguments,
    become_master,
    end_schedule,
    find_lin_line,
    lin_status_of,
)
from canwire.commands.lin.show import Shown, loaded_network, opened_monitor
from canwire.commands.lin.slots import described, with_delays
from canwire.commands.shared_hub import connected

if TYPE_CHECKING:
    from canwire import Hub, Monitor

_ROUND_S = 0.05  # between two looks whether a schedule is over


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_lin_arguments(parser)
    parser.add_argument(
        "slots", nargs="*", metavar="SLOT", help="10, 11:4@10ms (bytes asked for, time to the next), 12#0102"
    )
    parser.add_argument(
        "--rounds", type=int, default=0, metavar="N", help="end after this many (default: at Ctrl-C)"
    )
    parser.add_argument("--ldf", metavar="FILE", help="take a table and the master's frames from it instead")
    parser.add_argument("--table", metavar="NAME", help="which one of its schedules (default: the first)")


def run(arguments: argparse.Namespace) -> int:
    """Run it in the hub, and print what comes, until its rounds are over or Ctrl-C."""
    if arguments.rounds < 0:
        raise BadValue(f"--rounds {arguments.rounds}: 1 or more, or 0 for no limit")
    if bool(arguments.slots) == (arguments.ldf is not None):
        raise BadValue("give slots, or a description by --ldf")
    network = loaded_network(arguments.ldf)
    table, frames = described(network, arguments.table) if network else parse_lin_schedule(arguments.slots)
    with ExitStack() as closing:
        hub = connected(arguments, "lin schedule", closing)
        place = find_lin_line(hub, arguments.line, to_send=True)
        monitor = opened_monitor(hub, place, closing, events=True)
        rate = arguments.bit_rate or (None if network is None else network.bit_rate)
        control = become_master(hub, place, rate, closing)
        closing.callback(end_schedule, control)
        table = with_delays(table, lin_status_of(hub, place).bit_rate)
        for frame in frames:
            control.respond(frame)
        control.run_schedule(table, arguments.rounds)
        span_ns = arguments.rounds * sum(slot.delay_ns for slot in table.slots)
        shown = Shown(hub, monitor, arguments.line, network)
        try:
            _follow(hub, shown, monitor, hub.now_ns() + span_ns if span_ns else None)
        finally:
            complain(shown.summary())
    return 0


def _follow(hub: Hub, shown: Shown, monitor: Monitor, end_ns: int | None) -> None:
    """Show messages until the hub's time is `end_ns` (None: without end)."""
    over = False
    while True:
        message = monitor.receive(None if end_ns is None else 0 if over else _ROUND_S)
        if message is not None:
            shown.show(message)
        elif over:
            return
        elif end_ns is not None:
            over = hub.now_ns() >= end_ns  # a late hub catches up before it answers: then there may be more
