"""`canwire isotp send`."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack

from canwire import BadValue
from canwire.commands.console import complain
from canwire.commands.shared_hub import connected
from canwire.commands.transport.line import IsoTpLine, add_transport_arguments, load


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the sub-verb's arguments."""
    add_transport_arguments(parser)
    parser.add_argument("messages", nargs="+", metavar="HEX", help="22F190; - reads messages, one a line")
    parser.add_argument("--answer", action="store_true", help="print one answer for each message")


def run(arguments: argparse.Namespace) -> int:
    """Send; return 1 if a message was not accepted or not answered. Raises BadValue for invalid hex."""
    messages = [message_in(text) for text in texts_of(arguments.messages)]
    with ExitStack() as closing:
        line = IsoTpLine(connected(arguments, "isotp", closing), arguments, closing)
        for message in messages:
            if not _sent(line, message, arguments.timeout):
                return 1
            if arguments.answer:
                found = line.layer.recv(block=True, timeout=arguments.timeout)
                if found is None:
                    complain(f"no answer from {arguments.rx} in {arguments.timeout:g} s")
                    return 1
                print(bytes(found).hex().upper(), flush=True)
        return line.sending.result()


def texts_of(words: list[str]) -> list[str]:
    """Return the words; - is replaced by the lines of standard input."""
    return [
        text for word in words for text in (sys.stdin.read().splitlines() if word == "-" else [word]) if text
    ]


def message_in(text: str) -> bytes:
    """Return the bytes of hex digits, which blanks may separate; raises BadValue."""
    try:
        found = bytes.fromhex(text)
    except ValueError:
        found = b""
    if not found:
        raise BadValue(f"{text!r}: a message in hex, 22F190")
    return found


def _sent(line: IsoTpLine, message: bytes, timeout_s: float) -> bool:
    """Send the message; return whether all of it was sent, and print why if not."""
    errors = load("isotp").errors
    line.layer.params.set("blocking_send", True)
    try:
        line.layer.send(message)
    except errors.BlockingSendFailure as error:
        if line.sending.result() == 0:  # else it has said why frames stay behind
            complain(str(line.errors[-1] if line.errors else error))
        return False
    return True
