"""`canwire db`: show a database: messages, signals, a picture of each message's bits.

canwire db car.dbc                     a line for each message
canwire db car.dbc EngineData          one message: its signals and its bits (a name, or an identifier: 0x100)
canwire db car.dbc --search speed      messages and signals with this text in a name, comment or unit
canwire db car.dbc --diff engine.dbc   the differences from another file; status 1 if any
canwire db car.dbc --json              everything, for programs
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING

from canwire.commands.databases.chosen import KINDS, add_reading_arguments, loaded
from canwire.commands.databases.picture import picture_of

if TYPE_CHECKING:
    from canwire import Database, MessageDescription, SignalDescription


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("db", metavar="FILE", help=f"a {KINDS}")
    parser.add_argument(
        "messages",
        nargs="*",
        metavar="MESSAGE",
        help="show only these messages: names, or identifiers: 0x100",
    )
    parser.add_argument(
        "--search",
        metavar="TEXT",
        help="find messages and signals with this text in a name, comment or unit; ignores case",
    )
    parser.add_argument("--diff", metavar="OTHER", help="show the differences from the file OTHER")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_reading_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print the database; 1 if --search finds nothing or --diff finds something. BadDescription, BadValue."""
    database = loaded(arguments.db, arguments)
    chosen = [message for word in arguments.messages for message in _named(database, word)]
    if arguments.json:
        told = chosen or list(database.messages.values())
        print(json.dumps({"nodes": database.nodes, "messages": [asdict(one) for one in told]}, indent=2))
        return 0
    if arguments.diff is not None:
        differences = list(differences_of(database, loaded(arguments.diff, arguments)))
        print(*differences, sep="\n", end="\n" if differences else "")
        return 1 if differences else 0
    if arguments.search is not None:
        found = list(found_in(database, arguments.search.lower()))
        print(*found, sep="\n", end="\n" if found else "")
        return 0 if found else 1
    for message in chosen:
        print(*whole(message), sep="\n")
    if not chosen:
        print(*(line_of(message) for message in database.messages.values()), sep="\n")
    return 0


def line_of(message: MessageDescription) -> str:
    """Return one line that describes a message."""
    kind = "LIN" if message.lin else "FD" if message.fd else "J1939" if message.j1939 else ""
    cycle = f"every {message.cycle_s * 1000:g} ms" if message.cycle_s else ""
    words = [
        identifier_of(message),
        f"{message.name:<32}",
        f"{message.length:>3} bytes",
        f"{len(message.signals):>3} signals",
        kind,
        cycle,
        f"from {', '.join(message.senders)}" if message.senders else "",
    ]
    return "  ".join(word for word in words if word)


def whole(message: MessageDescription) -> Iterator[str]:
    """A message with its signals and its bits."""
    yield line_of(message)
    if message.comment:
        yield f"  {message.comment}"
    yield from (f"  {line}" for line in picture_of(message))
    for signal in message.signals.values():
        yield f"  {signal_text(signal)}"
    yield ""


def signal_text(signal: SignalDescription) -> str:
    """Return one line that describes a signal."""
    kind = "float" if signal.is_float else "signed" if signal.signed else "unsigned"
    order = "big endian" if signal.big_endian else "little endian"
    paged = ""
    if signal.multiplexer:
        paged = f"if {signal.multiplexer} is {', '.join(map(str, signal.multiplexer_ids))}"
    choices = ", ".join(f"{raw}: {text}" for raw, text in signal.choices.items())
    words = [
        signal.name,
        f"bit {signal.start_bit}, {signal.length} bits, {order}, {kind}",
        f"x {signal.scale:g} + {signal.offset:g}",
        f"{signal.minimum:g} to {signal.maximum:g} {signal.unit}".rstrip(),
        paged,
        choices,
        signal.comment,
    ]
    return "; ".join(word for word in words if word)


def found_in(database: Database, text: str) -> Iterator[str]:
    """Messages and signals with this text in their name, comment or unit."""
    for message in database.messages.values():
        if text in message.name.lower() or text in message.comment.lower():
            yield line_of(message)
        for signal in message.signals.values():
            if any(text in word.lower() for word in (signal.name, signal.comment, signal.unit)):
                yield f"{identifier_of(message)}  {message.name}.{signal_text(signal)}"


def differences_of(one: Database, other: Database) -> Iterator[str]:
    """What only one database contains (< and >) and what differs, by message and signal."""
    for name in dict.fromkeys([*one.messages, *other.messages]):
        if name not in other.messages:
            yield f"< {line_of(one.messages[name])}"
        elif name not in one.messages:
            yield f"> {line_of(other.messages[name])}"
        else:
            yield from _message_differences(one.messages[name], other.messages[name])


def _message_differences(one: MessageDescription, other: MessageDescription) -> Iterator[str]:
    if line_of(one) != line_of(other) or one.comment != other.comment:
        yield f"< {line_of(one)}{'; ' + one.comment if one.comment else ''}"
        yield f"> {line_of(other)}{'; ' + other.comment if other.comment else ''}"
    for name in dict.fromkeys([*one.signals, *other.signals]):
        for mark, signals in (("<", one.signals), (">", other.signals)):
            if name in signals and one.signals.get(name) != other.signals.get(name):
                yield f"{mark} {one.name}.{signal_text(signals[name])}"


def identifier_of(message: MessageDescription) -> str:
    """The identifier in hex, with eight digits if it has 29 bits."""
    return f"{message.id:08X}" if message.extended else f"{message.id:03X}".rjust(8)


def _named(database: Database, word: str) -> list[MessageDescription]:
    """By name, or by identifier; raises BadValue with near names."""
    if word in database.messages:
        return [database.messages[word]]
    try:
        id = int(word, 16) if word[:1].isdigit() else None
    except ValueError:
        id = None
    found = [message for message in database.messages.values() if message.id == id]
    return found or [database.message(word)]
