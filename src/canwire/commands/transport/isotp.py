"""`canwire isotp`: send and receive ISO-TP messages (ISO 15765-2) on a line of the hub, with can-isotp.

canwire isotp send can0 22F190                    a message to 7E0; flow control comes from 7E8
canwire isotp send can0 22F190 --answer           and print the answer
canwire isotp send can0 - --tx 18DA10F1 --rx 18DAF110    hex from standard input, identifiers of 29 bits
canwire isotp send can0 22F190 -x 12:F1 --tx 6F1 --rx 612    extended addressing: 12 before sent data
canwire isotp recv can0 --tx 7E8 --rx 7E0 -n 1    be the other side: send flow control, print one message
canwire isotp dump can0                           only listen: print each frame and each complete message
canwire isotp dump can0 --messages --seconds 10   print messages only

Messages are printed in hex, without blanks. `send` ends with status 1 if the other side did not accept the message or,
with --answer, did not answer within --timeout seconds.
"""

from __future__ import annotations

import argparse

from canwire.commands.transport import dump, recv, send


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    verbs = parser.add_subparsers(metavar="verb", required=True)
    for name, help, verb in (
        ("send", "send messages", send),
        ("recv", "receive messages, as the other side", recv),
        ("dump", "show the messages of others, only listening", dump),
    ):
        sub = verbs.add_parser(name, help=help, description=help)
        verb.add_arguments(sub)
        sub.set_defaults(isotp_verb=verb.run)


def run(arguments: argparse.Namespace) -> int:
    """Run the sub-verb. Raises HubError without a hub, NoSuchBoard, BadValue, ExtraMissing."""
    return int(arguments.isotp_verb(arguments))
