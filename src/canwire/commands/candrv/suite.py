"""CanTestSuite of the CANDRV manual, program by program: switches, output, log lines and exit codes are the manual's.

Two things differ: each error prints its cause on stderr, and a program that fails exits with 1. The manual's listings
continue at the old bit rate instead, and forget messages that could not be written.
Source: CANDRV manual, 10.1 to 10.3.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack

from canwire.commands.candrv.opening import DEVICE_ERROR, MESSAGES, USAGE, Failure, say
from canwire.commands.candrv.programs import can_mon, can_read, can_write
from canwire.commands.candrv.stress import can_send
from canwire.commands.candrv.switches import Program, Usage, parse

_COMMON = (
    ("d", "<dev>", "Device name (CID1:)"),
    ("b", "<baud>", "Set baudrate"),
    ("f", "<name>", "Log file name"),
)
_STRESS = (
    ("n", "<num>", f"Messages of each thread ({MESSAGES})"),
    ("c", "<num>", "Send channels (1)"),
    ("t", "<num>", "Threads on each channel (1)"),
)
PROGRAMS = {
    "write": Program(
        "CanWrite", "CanWrite: send 1000 messages with increasing identifiers", _COMMON, can_write
    ),
    "read": Program("CanRead", "CanRead: show all events as ReadFile gives them", _COMMON, can_read),
    "send": Program("CanSend", "CanSend: stress the driver", (*_COMMON, *_STRESS), can_send),
    "mon": Program("CanMon", "CanMon: show all events of the binary interface", _COMMON, can_mon),
}


def run(arguments: argparse.Namespace) -> int:
    """Run one program with its words; returns its exit status: 0, 1 or 2."""
    program: Program = arguments.candrv_program
    say(f"{program.name} V3.0")
    try:
        switches = parse(program, arguments.words)
    except Usage as wrong:
        say("\n".join(filter(None, (str(wrong), program.usage))))
        return USAGE
    with ExitStack() as closing:
        try:
            return program.body(switches, closing)
        except Failure as failure:
            say(str(failure))
            return DEVICE_ERROR
