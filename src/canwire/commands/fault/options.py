"""Arguments of the kinds of faults: what they are called, and what they mean to the hub."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from canwire import BadValue

Parser = argparse.ArgumentParser
Arguments = argparse.Namespace
_LEVELS = ("dominant", "recessive")
_NUMBERS = {
    "octets": ("bytes that are sent", 1),
    "octet": ("which byte of the response, from 0", 0),
    "bit": ("which bit of it, 0 to 7", 0),
    "bits": ("length of the break", 10),
    "value": ("the byte, in hex with 0x", 0x54),
}


def _add_id(parser: Parser, help: str = "only frames of this identifier, hex; 8 digits: extended") -> None:
    parser.add_argument("--id", metavar="ID", help=help)


def _add_often(parser: Parser, usual: int | None = 1) -> None:
    shown = "without end" if usual is None else usual
    parser.add_argument(
        "--times", type=int, default=usual, metavar="N", help=f"how often, 0: without end (default: {shown})"
    )


def _add_seen_by(parser: Parser) -> None:
    parser.add_argument(
        "--seen-by",
        default="all",
        metavar="WHO",
        help="all, receivers, sender, or lines: HW000001:0,HW000001:1",
    )


def _add_at(parser: Parser, example: str = "eof:2") -> None:
    parser.add_argument(
        "--at",
        metavar="PART:BIT",
        help=f"a place as docs/faults.md names them: {example}, intermission:1 (default: immediately)",
    )
    parser.add_argument("--of", metavar="LINE", help="whose bits are counted (default: the sender's)")
    _add_id(parser)


def for_flip(parser: Parser) -> None:
    """Add the options of `canwire fault BUS flip`."""
    parser.add_argument(
        "--bit",
        required=True,
        help="number from SOF (0), stuff bits included, or ack, eof, crc delimiter, data ...",
    )
    _add_id(parser)
    _add_often(parser)
    _add_seen_by(parser)


def for_inject(parser: Parser) -> None:
    """Add the options of `canwire fault BUS inject`."""
    parser.add_argument("error", choices=("stuff", "form", "crc", "bit", "ack"), help="kind of error")
    _add_id(parser)
    _add_often(parser)


def for_noise(parser: Parser) -> None:
    """Add the options of `canwire fault BUS noise`."""
    parser.add_argument("--rate", type=float, required=True, help="share of bits read wrong: 1e-4")


def for_hold(parser: Parser) -> None:
    """Add the options of `canwire fault BUS hold`."""
    parser.add_argument("level", choices=_LEVELS)
    parser.add_argument(
        "--bits",
        type=int,
        default=1,
        metavar="N",
        help="how long, 0: as long as the fault is there (default: 1)",
    )
    _add_at(parser)
    _add_often(parser)
    _add_seen_by(parser)


def for_play(parser: Parser) -> None:
    """Add the options of `canwire fault BUS play`."""
    parser.add_argument("levels", help="one sign a bit: 0 dominant, 1 recessive, - nothing: 000--1")
    _add_at(parser)
    _add_often(parser)
    _add_seen_by(parser)


def for_glitch(parser: Parser) -> None:
    """Add the options of `canwire fault BUS glitch`."""
    parser.add_argument("level", choices=_LEVELS)
    parser.add_argument("--width", type=float, required=True, metavar="NS", help="nanoseconds")
    parser.add_argument("--start", type=float, default=0.0, metavar="NS", help="so long behind the place")
    _add_at(parser)
    _add_often(parser)
    _add_seen_by(parser)


def for_move_edge(parser: Parser) -> None:
    """Add the options of `canwire fault BUS move-edge`."""
    parser.add_argument("quanta", type=int, help="time quanta back, negative: forward")
    parser.add_argument("--to", choices=_LEVELS, default="dominant", help="which edge (default: dominant)")
    _add_at(parser, "frame:13")
    _add_often(parser)
    _add_seen_by(parser)


def for_line(parser: Parser) -> None:
    """Add the options of `canwire fault BUS unplug`."""
    parser.add_argument("line", metavar="LINE", help="HW000001:1")


def for_drift(parser: Parser) -> None:
    """Add the options of `canwire fault BUS drift`."""
    for_line(parser)
    parser.add_argument("ppm", type=float, help="parts per million, negative: slow; up to 100000")


def for_rate(parser: Parser) -> None:
    """Add the options of `canwire fault BUS rate`."""
    for_line(parser)
    parser.add_argument("bit_rate", type=int, metavar="BIT/S", help="in place of the configured one")


def for_cable(parser: Parser) -> None:
    """Add the options of `canwire fault BUS cable`."""
    parser.add_argument("metres", type=float, help="length; 0: an ideal one")
    parser.add_argument(
        "--node-delay", type=float, default=0.0, metavar="NS", help="of each node, 75 an opto-coupler"
    )


def for_babble(parser: Parser) -> None:
    """Add the options of `canwire fault BUS babble`."""
    _add_id(parser, "of an empty frame, hex; 8 digits: extended (default: 000)")
    parser.add_argument("--frame", metavar="FRAME", help="a whole frame: 123#1122")
    parser.add_argument(
        "--gap", type=float, default=0.0, metavar="SECONDS", help="from one to the next (default: none)"
    )
    _add_often(parser, None)


def for_nothing(parser: Parser) -> None:
    """short"""


def for_lin(*numbers: str) -> Callable[[Parser], None]:
    """LIN kinds: these numbers, an identifier, how often."""

    def add(parser: Parser) -> None:
        for number in numbers:
            help, usual = _NUMBERS[number]
            parser.add_argument(
                f"--{number}",
                type=lambda text: int(text, 0),
                default=usual,
                help=f"{help} (default: {usual:#x})",
            )
        _add_id(parser, "only frames of this identifier, hex: 0 to 3F")
        _add_often(parser)

    return add


# what they mean


def frames(arguments: Arguments) -> dict[str, Any]:
    """`frame_id` and `extended` of --id; raises BadValue."""
    if arguments.id is None:
        return {"frame_id": None, "extended": None}
    try:
        return {"frame_id": int(arguments.id, 16), "extended": len(arguments.id) > 3}
    except ValueError:
        raise BadValue(f"--id {arguments.id}: hex digits, 3 or for an extended frame 8") from None


def lin_id(text: str) -> int:
    """Return the identifier that this hexadecimal text gives; raises BadValue."""
    try:
        return int(text, 16)
    except ValueError:
        raise BadValue(f"--id {text}: hex digits, 0 to 3F") from None


def often(arguments: Arguments) -> dict[str, int | None]:
    """Return `times` by --times; 0 is None, no limit."""
    return {"times": None if arguments.times == 0 else arguments.times}


def stay(arguments: Arguments) -> dict[str, Any]:
    """`lasting` and `persistent` of --for and --stay."""
    return {"lasting": arguments.lasting, "persistent": arguments.stay}


def seen_by(arguments: Arguments) -> str | list[str]:
    """The value of --seen-by."""
    names = str(arguments.seen_by).split(",")
    return names[0] if len(names) == 1 else names


def at(faults: Any, arguments: Arguments) -> Any:
    """The place of --at, or None; raises BadValue."""
    if arguments.at is None:
        if arguments.id is not None or arguments.of is not None:
            raise BadValue("--id and --of say where --at is: add --at")
        return None
    part, _, bit = arguments.at.partition(":")
    if bit and not bit.isdigit():
        raise BadValue(f"--at {arguments.at}: a part and the number of a bit: eof:2")
    return faults.place(part, int(bit or 1), **frames(arguments), node=arguments.of)
