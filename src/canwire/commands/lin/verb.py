"""`canwire lin`: watch a LIN line, send from one as its master, run a schedule.

canwire lin dump lin0                         the first line on that bus; started as slave if nobody did
canwire lin dump lin0 -e --ldf door.ldf       errors and state changes as well; values of signals
canwire lin send lin0 10#0102 11#R4           as master: a frame, then a header for somebody to answer
canwire lin schedule lin0 10#0102 11:4@10ms   slot after slot, while it runs; 11 is asked for 4 bytes
canwire lin schedule lin0 --ldf door.ldf --table Normal --rounds 10

Everything is shown as log lines: T behind what the line itself sent, R behind what it received. Sending takes the
line's control: one at a time. Exit status of `send`: 1 if something was not seen on the bus.
"""

from __future__ import annotations

import argparse

from canwire.commands.lin import dump, schedule, send


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    verbs = parser.add_subparsers(metavar="verb", required=True)
    for name, help, verb in (
        ("dump", "show what happens on a line", dump),
        ("send", "send frames as master", send),
        ("schedule", "run a schedule as master", schedule),
    ):
        sub = verbs.add_parser(name, help=help, description=help)
        verb.add_arguments(sub)
        sub.set_defaults(lin_verb=verb.run)


def run(arguments: argparse.Namespace) -> int:
    """The sub-verb; HubError without a hub, NoSuchBoard, BadValue, BadText, InUse for what cannot be."""
    return int(arguments.lin_verb(arguments))
