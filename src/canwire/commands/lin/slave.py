"""`canwire lin slave`: a slave that answers node configuration, as bought ones do."""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from canwire import (
    BadValue,
    InUse,
    LinFrame,
    LinMode,
    LinNodeAttributes,
    LinProduct,
    parse_lin_frame,
)
from canwire.commands.console import complain
from canwire.commands.lin.line import USUAL_BIT_RATE, add_lin_arguments, find_lin_line, point_out_rates
from canwire.commands.lin.show import Shown, loaded_network, opened_monitor
from canwire.commands.shared_hub import connected

if TYPE_CHECKING:
    from canwire import LinControl


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_lin_arguments(parser)
    parser.add_argument(
        "frames",
        nargs="*",
        metavar="FRAME",
        help="what it answers: 20#05; configurable by index: 0=20#05, 1=10#R",
    )
    parser.add_argument("--ldf", metavar="FILE", help="take frames and Node_attributes from it instead")
    parser.add_argument("--node", metavar="NAME", help="which one of its slaves")
    for name, usual in (("nad", "01"), ("supplier", "0001"), ("function", "0001"), ("variant", "00")):
        parser.add_argument(f"--{name}", default=usual, metavar="HEX", help=f"its {name} (%(default)s)")
    parser.add_argument("--serial", metavar="HEX", help="its serial number, 32 bits")
    parser.add_argument("-n", "--count", type=int, metavar="COUNT", help="end after this many lines")


def run(arguments: argparse.Namespace) -> int:
    """Answer, and print what is heard, until Ctrl-C."""
    if bool(arguments.ldf) != bool(arguments.node) or (arguments.ldf and arguments.frames):
        raise BadValue("give a description by --ldf and one of its slaves by --node, or frames")
    network = loaded_network(arguments.ldf)
    attributes, responses = _described(network, arguments.node) if network else _given(arguments)
    with ExitStack() as closing:
        hub = connected(arguments, "lin slave", closing)
        place = find_lin_line(hub, arguments.line, to_send=True)
        monitor = opened_monitor(hub, place, closing, events=True)
        try:
            control = closing.enter_context(hub.open_lin_control(place.board.id, place.line))
        except InUse as error:
            raise InUse(f"a line is one slave, or its master: {error}") from None
        rate = arguments.bit_rate or (None if network is None else network.bit_rate)
        _begin(control, rate, attributes, responses)
        point_out_rates(hub, place)
        complain(
            f"{place.address} on {place.info.bus or 'no bus'}: slave at NAD {attributes.nad:02X}; listening"
        )
        shown = Shown(hub, monitor, arguments.line, network)
        try:
            while arguments.count is None or shown.lines < arguments.count:
                message = monitor.receive(None)
                if message is not None:
                    shown.show(message)
        finally:
            complain(shown.summary())
    return 0


def _begin(
    control: LinControl, rate: int | None, attributes: LinNodeAttributes, responses: list[LinFrame]
) -> None:
    control.initialise(LinMode(False, USUAL_BIT_RATE if rate is None else rate, errors=True))
    for frame in responses:
        control.respond(frame)
    control.configure(attributes)
    control.start()


def _described(network: Any, node: str) -> tuple[LinNodeAttributes, list[LinFrame]]:
    attributes = network.attributes(node)
    if attributes is None:
        raise BadValue(f"{network.path}: {node} has no Node_attributes of LIN 2.0 or later with a product_id")
    return attributes, list(network.responses(node).values())


def _given(arguments: argparse.Namespace) -> tuple[LinNodeAttributes, list[LinFrame]]:
    indexed: dict[int, int] = {}
    responses = []
    for text in arguments.frames:
        index, separator, frame = text.rpartition("=")
        parsed = parse_lin_frame(frame)
        if not parsed.header_only:  # else it only hears that one
            responses.append(parsed)
        if separator:
            if not index.isdecimal():
                raise BadValue(f"frame {text!r}: like 20#05, or 0=20#05 for the one with index 0")
            indexed[int(index)] = parsed.id
    product = LinProduct(*(_number(arguments, name) for name in ("supplier", "function", "variant")))
    serial = None if arguments.serial is None else _number(arguments, "serial")
    return LinNodeAttributes(product, _number(arguments, "nad"), indexed, serial), responses


def _number(arguments: argparse.Namespace, name: str) -> int:
    text = getattr(arguments, name)
    try:
        return int(text, 16)
    except ValueError:
        raise BadValue(f"--{name} {text!r}: a number in hex") from None
