"""`canwire lin`: watch a LIN line, send as its master, run a schedule, configure slaves, or act as a slave.

canwire lin dump lin0                         the first line on that bus; started as slave if it does not run
canwire lin dump lin0 -e --ldf door.ldf       errors and state changes as well; values of signals
canwire lin send lin0 10#0102 11#R4           as master: a frame, then a header that a slave answers
canwire lin schedule lin0 10#0102 11:4@10ms   slot after slot, while it runs; 11 is asked for 4 bytes
canwire lin schedule lin0 --ldf door.ldf --table Normal --rounds 10
canwire lin slave lin0 --nad 11 0=20#05       a slave with node configuration; 20 is its frame 0
canwire lin slave lin0 --ldf door.ldf --node left
canwire lin identify lin0 11                  as master: who has NAD 11? --id 1 for its serial number
canwire lin assign lin0 11 --nad 22           another NAD for the slave whose initial one is 11
canwire lin assign lin0 22 --frames 0:0E      identifier 0E for its frame 0
canwire lin save lin0 22
canwire lin request lin0 22 B2.00.FF7F.FFFF   any request through the transport layer

Everything is shown as log lines: T after what the line itself sent, R after what it received. Sending takes the
line's control, which one program can hold. Exit status 1 if something that was sent was not seen on the bus, or
a slave refused.
"""

from __future__ import annotations

import argparse

from canwire.commands.lin import dump, request, schedule, send, slave


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    verbs = parser.add_subparsers(metavar="verb", required=True)
    for name, help, arguments, verb in (
        ("dump", "show what happens on a line", dump.add_arguments, dump.run),
        ("send", "send frames as master", send.add_arguments, send.run),
        ("schedule", "run a schedule as master", schedule.add_arguments, schedule.run),
        ("slave", "be a slave with node configuration", slave.add_arguments, slave.run),
        ("identify", "ask a slave who it is", request.add_identify_arguments, request.identify),
        (
            "assign",
            "give a slave a NAD, or its frames identifiers",
            request.add_assign_arguments,
            request.assign,
        ),
        ("save", "have a slave keep its configuration", request.add_save_arguments, request.save),
        ("request", "a request through the transport layer", request.add_request_arguments, request.request),
    ):
        sub = verbs.add_parser(name, help=help, description=help)
        arguments(sub)
        sub.set_defaults(lin_verb=verb)


def run(arguments: argparse.Namespace) -> int:
    """The sub-verb; HubError without a hub, NoSuchBoard, BadValue, BadText, InUse for what cannot be."""
    return int(arguments.lin_verb(arguments))
