"""`canwire isotp`: messages longer than a frame (ISO 15765-2) on a line of the hub, by can-isotp.

canwire isotp send can0 22F190                    a message to 7E0; flow control comes from 7E8
canwire isotp send can0 22F190 --answer           and print what comes back
canwire isotp send can0 - --tx 18DA10F1 --rx 18DAF110    hex from standard input, identifiers of 29 bits
canwire isotp send can0 22F190 -x 12:F1 --tx 6F1 --rx 612    extended addressing: 12 before what is sent
canwire isotp recv can0 --tx 7E8 --rx 7E0 -n 1    be the other side: print a message, and send its flow control
canwire isotp dump can0                           only listen: each frame, and each message that is complete
canwire isotp dump can0 --messages --seconds 10   messages alone

Messages are printed in hex, without blanks. `send` ends with status 1 if the other side did not take the message, or
with --answer did not answer in --timeout seconds.
"""

from __future__ import annotations

import argparse

from canwire.commands.transport import dump, recv, send


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    verbs = parser.add_subparsers(metavar="verb", required=True)
    for name, help, verb in (
        ("send", "send messages", send),
        ("recv", "receive messages, as the other side", recv),
        ("dump", "show what others send, only listening", dump),
    ):
        sub = verbs.add_parser(name, help=help, description=help)
        verb.add_arguments(sub)
        sub.set_defaults(isotp_verb=verb.run)


def run(arguments: argparse.Namespace) -> int:
    """The sub-verb; HubError without a hub, NoSuchBoard, BadValue, ExtraMissing for what cannot be."""
    return int(arguments.isotp_verb(arguments))
