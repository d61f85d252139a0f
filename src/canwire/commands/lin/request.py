"""`canwire lin request`, `identify`, `assign` and `save`: a master's requests through the transport layer."""

from __future__ import annotations

import argparse
from contextlib import ExitStack

from canwire import (
    BadValue,
    assign_frame_ids_request,
    assign_nad_request,
    lin_refusal,
    read_by_identifier_request,
    save_configuration_request,
)
from canwire.commands.console import complain
from canwire.commands.lin.line import add_lin_arguments, become_master, find_lin_line
from canwire.commands.shared_hub import connected

_UNCHANGED = -1
_SERIAL, _OWN = 1, 32


def add_request_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `request`."""
    _add_node(parser, "01 to 7F, or 7E for all nodes, which none answers")
    parser.add_argument("payload", metavar="HEX", help="service and data: B2.00.FF7F.FFFF (up to 4095 bytes)")
    _add_timeout(parser)


def add_identify_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `identify`."""
    _add_node(parser, "its NAD: 01 to FF")
    parser.add_argument(
        "--id", type=int, default=0, metavar="N", help="1: serial number, 32 to 63: its supplier's"
    )
    _add_product(parser)
    _add_timeout(parser)


def add_assign_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `assign`."""
    _add_node(parser, "its NAD, with --nad the initial one")
    wanted = parser.add_mutually_exclusive_group(required=True)
    wanted.add_argument("--nad", metavar="NAD", help="the NAD that it is to have")
    wanted.add_argument(
        "--frames", metavar="INDEX:ID,ID", help="identifiers from that frame on: 0:10,-,none (- keeps it)"
    )
    _add_product(parser)
    _add_timeout(parser)


def add_save_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `save`."""
    _add_node(parser, "its NAD: 01 to FF")
    _add_timeout(parser)


def request(arguments: argparse.Namespace) -> int:
    """Print NAD and payload of the response; 1 if there is none, or a negative one."""
    try:
        payload = bytes.fromhex(arguments.payload.replace(".", "").replace("#", ""))
    except ValueError:
        raise BadValue(f"payload {arguments.payload!r}: bytes in hex, like B2.00.FF7F.FFFF") from None
    return _ask(arguments, payload, lambda answer: answer.hex(" ").upper())


def identify(arguments: argparse.Namespace) -> int:
    """Print the identification that the node returns."""
    wanted = read_by_identifier_request(arguments.id, *_product(arguments))

    def words(answer: bytes) -> str:
        data = answer[1:]
        if arguments.id == 0 and len(data) >= 5:
            supplier, function = (int.from_bytes(data[at : at + 2], "little") for at in (0, 2))
            return f"supplier {supplier:04X}, function {function:04X}, variant {data[4]}"
        if arguments.id == _SERIAL and len(data) >= 4:
            return f"serial number {int.from_bytes(data[:4], 'little')}"
        return f"identifier {arguments.id}: {data.hex(' ').upper()}"

    return _ask(arguments, wanted, words)


def assign(arguments: argparse.Namespace) -> int:
    """Assign a NAD to a node, or identifiers to its frames."""
    if arguments.frames is None:
        wanted = assign_nad_request(_octet("--nad", arguments.nad), *_product(arguments))
        return _ask(arguments, wanted, lambda answer: f"is NAD {arguments.nad} now")
    return _ask(arguments, assign_frame_ids_request(*_frames(arguments.frames)), lambda answer: "done")


def save(arguments: argparse.Namespace) -> int:
    """Have the node keep its configuration."""
    return _ask(arguments, save_configuration_request(), lambda answer: "saved")


def _ask(arguments: argparse.Namespace, payload: bytes, words: object) -> int:
    """Send the request as master and print the answer; returns 1 if the node refuses. Raises NotReceived."""
    assert callable(words)
    nad = _octet("NAD", arguments.node)
    with ExitStack() as closing:
        hub = connected(arguments, "lin request", closing)
        place = find_lin_line(hub, arguments.line, to_send=True)
        control = become_master(hub, place, arguments.bit_rate, closing)
        answer = control.request(nad, payload, within=arguments.timeout)
    if why := lin_refusal(answer):
        complain(f"NAD {nad:02X}: {why}")
        return 1
    print(f"NAD {nad:02X}: {words(answer)}" if answer else f"NAD {nad:02X}: sent")
    return 0


def _add_node(parser: argparse.ArgumentParser, help: str) -> None:
    add_lin_arguments(parser)
    parser.add_argument("node", metavar="NAD", help=help)


def _add_product(parser: argparse.ArgumentParser) -> None:
    for name, usual in (("supplier", "7FFF"), ("function", "FFFF")):
        parser.add_argument(f"--{name}", default=usual, metavar="HEX", help=f"only a node of this {name}")


def _add_timeout(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--timeout", type=float, default=1.0, metavar="SECONDS", help="give up after this long (1)"
    )


def _product(arguments: argparse.Namespace) -> tuple[int, int]:
    return _number("--supplier", arguments.supplier), _number("--function", arguments.function)


def _frames(text: str) -> tuple[int, list[int | None]]:
    """`0:10,-,none` as an index and identifiers."""
    index, separator, ids = text.partition(":")
    if not separator or not index.isdecimal():
        raise BadValue(f"--frames {text!r}: an index and identifiers, like 0:10,-,none")
    kept: dict[str, int | None] = {"-": _UNCHANGED, "none": None}
    return int(index), [kept[id] if id in kept else _octet("--frames", id) for id in ids.split(",")]


def _octet(name: str, text: str) -> int:
    value = _number(name, text)
    if value > 0xFF:
        raise BadValue(f"{name} {text}: from 00 to FF")
    return value


def _number(name: str, text: str) -> int:
    try:
        return int(text, 16)
    except ValueError:
        raise BadValue(f"{name} {text!r}: a number in hex") from None
